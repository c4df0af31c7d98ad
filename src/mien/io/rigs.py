"""Rigs from files of any kind: `.glb`, or a folder of meshes that share their vertices."""

from pathlib import Path

import numpy as np

from ..errors import BadInput
from ..files import existing
from ..rig import Rig
from .gltf import read_rig
from .meshes import read_scan

SUFFIXES = (".obj", ".ply")


def read_any_rig(path: str | Path, unit: str | None = None) -> Rig:
    """Read a rig from a `.glb` (see `read_rig`) or from a folder of OBJ or PLY files (see `read_rig_folder`).

    Raises:
        BadInput: missing, neither, or what those raise.
    """
    path = existing(path)
    if path.is_dir():
        return read_rig_folder(path, unit)
    if path.suffix.lower() == ".glb":
        return read_rig(path)
    raise BadInput(f"{path}: is no rig; give a .glb with morph targets or a folder of .obj or .ply, one named neutral")


def read_rig_folder(folder: str | Path, unit: str | None = None) -> Rig:
    """A rig from a folder of meshes with the same vertices: the one named neutral and its shapes.

    Shapes are named after the files' stems, in alphabetical order. Faces, texture and colours are the neutral's. `unit`
    as in `read_scan`.

    Raises:
        BadInput: no or several neutrals, no other mesh, a mesh of another vertex count, or what `read_scan` raises.
    """
    folder = existing(folder)
    visible = [file for file in folder.iterdir() if not file.name.startswith(".")]
    files = sorted(file for file in visible if file.suffix.lower() in SUFFIXES)
    neutrals = [file for file in files if file.stem.lower().startswith("neutral")]
    if len(neutrals) != 1:
        names = ", ".join(file.name for file in neutrals) or "none"
        raise BadInput(f"{folder}: needs exactly one .obj or .ply whose name starts with neutral, has {names}")
    targets = [file for file in files if file != neutrals[0]]
    stems = [file.stem for file in targets]
    if not targets or len(set(stems)) < len(stems):
        problem = "two meshes of one name" if targets else f"no mesh beside {neutrals[0].name}"
        raise BadInput(f"{folder}: has {problem}; put one .obj or .ply for every shape there")
    neutral = read_scan(neutrals[0], unit)
    n = len(neutral.mesh.vertices)
    deltas = np.empty((len(targets), n, 3))
    for i, file in enumerate(targets):
        vertices = read_scan(file, unit).mesh.vertices
        if len(vertices) != n:
            raise BadInput(f"{file}: has {len(vertices)} vertices, {neutrals[0].name} {n}; export both from one mesh")
        deltas[i] = vertices - neutral.mesh.vertices
    return Rig(neutral.mesh, deltas, tuple(stems), neutral.texture)
