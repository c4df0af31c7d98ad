"""`mien retarget`: a performance moves to another rig."""

from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from jaxtyping import Int

from ..errors import BadInput
from ..io.gltf import read_performance, write_performance
from ..io.rigs import read_any_rig
from ..landmarks.face_correspondence import match_faces
from ..rig import Rig
from ..rig.retarget import CORRECTIVE
from ..rig.retarget import retarget as move
from .options import verb
from .outputs import check_outputs


@verb
def retarget(
    performance: Path,
    *,
    to: Path,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("out.glb"),
    correctives: bool = True,
) -> None:
    """A performance in, the same performance on another rig out: coefficients by name, head pose, correctives.

    Parameters
    ----------
    performance
        What `mien track` or `mien solve` wrote (.glb).
    to
        The rig that is to play it (.glb, or a folder of OBJ or PLY).
    output
        Where the result goes (.glb).
    correctives
        Transfer what the blendshapes could not say too; --no-correctives leaves it out.
    """
    check_outputs({"an animated face": output}, inputs=[performance, to])
    played, target = read_performance(performance), read_any_rig(to)
    match, note = None, ""
    if correctives and any(name.startswith(CORRECTIVE) for name in played.rig.names):
        match, note = correspondence(played.rig, target)
    result = move(played, target, match, correctives)
    write_performance(output, result.performance)
    line = f"{output}: {len(result.moved)} shapes and {result.correctives} correctives on {to}{note}"
    if result.dropped:
        line += f"; the target has nothing for {', '.join(result.dropped)}"
    print(line)


def correspondence(source: Rig, target: Rig) -> tuple[Int[np.ndarray, " target_faces"] | None, str]:
    """Which triangles belong together, and a note; None where the two are the same surface, or show no landmarks."""
    if np.array_equal(source.neutral.faces, target.neutral.faces):
        return None, ""
    try:
        return match_faces(source, target), ""
    except BadInput as error:
        return None, f"; correctives went by nearest points alone ({error})"
