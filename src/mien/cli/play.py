"""A performance onto whatever rig a file holds: shared by `retarget` and `convert --rig`."""

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Int

from ..errors import BadInput
from ..io.gltf.avatar import is_ours, write_on_avatar
from ..io.gltf.vrm import expression_pairs
from ..io.performances import write_any_performance
from ..io.rigs import GLTF, read_any_rig
from ..landmarks.face_correspondence import match_faces
from ..rig import Performance, Rig
from ..rig.retarget import CORRECTIVE, Retargeted, retarget


def tell(line: str) -> None:
    """A line on what was assumed, beside the output."""
    print(f"mien: {line}", file=sys.stderr)


def play_on(
    performance: Performance, to: Path, output: Path, given: Mapping[str, str], correctives: bool = True
) -> tuple[Retargeted, str]:
    """Write a performance on the rig of `to`; everything else in that file stays. Also a note on correctives."""
    target = read_any_rig(to, tell=tell)
    match, note = None, ""
    if correctives and any(name.startswith(CORRECTIVE) for name in performance.rig.names):
        match, note = correspondence(performance.rig, target)
    is_gltf = to.is_file() and to.suffix.lower() in GLTF
    pairs = {**expression_pairs(to, performance.rig.names), **given} if is_gltf else given
    result = retarget(performance, target, match, correctives, pairs)
    lines = list(result.notes)
    if is_gltf and output.suffix.lower() == ".glb" and not is_ours(to):
        lines += write_on_avatar(to, output, result.performance, performance, pairs)
    else:
        write_any_performance(output, result.performance)
    for line in lines:
        tell(line)
    return result, note


def correspondence(source: Rig, target: Rig) -> tuple[Int[np.ndarray, " target_faces"] | None, str]:
    """Which triangles belong together, and a note; None where the two are the same surface, or show no landmarks."""
    if np.array_equal(source.neutral.faces, target.neutral.faces):
        return None, ""
    try:
        return match_faces(source, target), ""
    except BadInput as error:
        return None, f"; correctives went by nearest points alone ({error})"
