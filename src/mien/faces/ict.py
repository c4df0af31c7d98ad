"""ICT-FaceKit's light face model (Li et al. 2020) as a rig: a folder of OBJs in one topology. MIT, not bundled."""

from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..files import existing
from ..io.meshes import read_scan
from ..mesh import Mesh, Scan
from ..progress import SILENT, Progress
from ..rig import Rig
from .arkit import ARKIT_NAMES
from .bundled import IdentitySpace

NEUTRAL = "generic_neutral_mesh"
AREAS: dict[str, int] = {"full": 9409, "narrow": 6706}
"""Vertices of each area, counted from 0: the kit's order begins with the narrow face, then the full one."""
SPLIT = ("browInnerUp", "cheekPuff")
"""ARKit shapes of both sides that the kit stores as two halves."""


def load_ict(folder: str | Path, area: str = "full", progress: Progress = SILENT) -> tuple[Rig, IdentitySpace]:
    """Read the kit's `FaceXModel` folder: its neutral with 51 of the 52 ARKit shapes, and its identity modes.

    Millimetres (the files are in centimetres), +Y up, +Z out of the face, +X to the subject's left, the kit's own
    origin; quads become two triangles each, vertices keep their order. `_L` and `_R` become `Left` and `Right`, the
    halves of `browInnerUp` and `cheekPuff` are added up. The kit has no `tongueOut`. Its `mouthClose` corrects
    `jawOpen` and means nothing by itself: weigh it no more than `jawOpen`. OBJs that are no ARKit shape are left out.
    Identity coefficients are in standard deviations.

    Args:
        folder: holds `generic_neutral_mesh.obj`, `jawOpen.obj`, ..., `identity000.obj`, ...
        area: "full" face (9,409 vertices), "narrow" face (6,706), or "all" with head, eyes, teeth (26,719).
        progress: told after each file.

    Raises:
        BadInput: another area; the neutral, an expression or every identity is missing; vertex counts differ.
    """
    folder = existing(folder)
    if area not in ("all", *AREAS):
        raise BadInput(f"area {area!r}: there are full, narrow and all")
    path = folder / f"{NEUTRAL}.obj"
    if not path.is_file():
        raise BadInput(f"{folder}: has no {NEUTRAL}.obj; give ICT-FaceKit's folder FaceXModel")
    scan = read_scan(path, unit="cm")
    count = len(scan.mesh.vertices) if area == "all" else AREAS[area]
    if len(scan.mesh.vertices) < count:
        raise BadInput(f"{path}: has {len(scan.mesh.vertices)} vertices, the {area} face {count}; give area='all'")
    names = tuple(name for name in ARKIT_NAMES if name != "tongueOut")
    halves = [part for name in names for part in _files(name)]
    identities = sorted(folder.glob("identity[0-9][0-9][0-9].obj"))
    if not identities:
        raise BadInput(f"{folder}: has no identity000.obj; give ICT-FaceKit's whole folder FaceXModel")
    paths = [folder / f"{half}.obj" for half in halves] + identities
    fields = _displacements(scan, paths, count, progress)
    deltas = np.stack([sum(fields[halves.index(part)] for part in _files(name)) for name in names])
    modes = fields[len(halves) :]
    return Rig(_crop(scan.mesh, count), deltas, names, scan.texture), IdentitySpace(modes)


def _files(name: str) -> tuple[str, ...]:
    """The stems of the kit's files that make up one ARKit shape."""
    if name in SPLIT:
        return f"{name}_L", f"{name}_R"
    for side in ("Left", "Right"):
        if name.endswith(side) and name not in ("jawLeft", "jawRight", "mouthLeft", "mouthRight"):
            return (f"{name.removesuffix(side)}_{side[0]}",)
    return (name,)


def _displacements(scan: Scan, paths: list[Path], count: int, progress: Progress) -> Float[np.ndarray, "k n 3"]:
    """The first `count` vertices of each file, less the neutral's."""
    neutral = scan.mesh.vertices
    out = np.empty((len(paths), count, 3))
    for i, path in enumerate(paths):
        if not path.is_file():
            raise BadInput(f"{path.parent}: has no {path.name}; give ICT-FaceKit's whole folder FaceXModel")
        vertices = read_scan(path, unit="cm").mesh.vertices
        if len(vertices) != len(neutral):
            raise BadInput(f"{path}: has {len(vertices)} vertices, {NEUTRAL}.obj {len(neutral)}; take both of one kit")
        out[i] = (vertices - neutral)[:count]
        progress.update("reading ICT-FaceKit", i + 1, len(paths))
    return out


def _crop(mesh: Mesh, count: int) -> Mesh:
    """The first `count` vertices and the triangles that lie within them."""
    keep = (mesh.faces < count).all(axis=1)
    uv = mesh.uv[:count] if mesh.uv is not None and mesh.uv_faces is None else mesh.uv
    uv_faces = None if mesh.uv_faces is None else mesh.uv_faces[keep]
    colors = None if mesh.colors is None else mesh.colors[:count]
    return Mesh(mesh.vertices[:count], mesh.faces[keep], uv, uv_faces, colors)
