"""Rigs from and to files of any kind: glTF, USD, a folder of meshes that share their vertices."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..errors import BadInput
from ..files import existing
from ..mesh import Scan
from ..rig import Rig
from . import usd
from .gltf import read_rig, write_rig
from .meshes import read_scan
from .units import UNITS

SUFFIXES = (".obj", ".ply")
GLTF = (".glb", ".gltf", ".vrm")
_FACE_MM = (130.0, 900.0)
"""Box diagonals that are taken for a face or a head with its neck: of mm, m and cm only one can fit."""
_TRIED = ("mm", "m", "cm")


def _unheard(_: str) -> None:
    """Nobody listens."""


def read_any_rig(path: str | Path, unit: str | None = None, tell: Callable[[str], None] = _unheard) -> Rig:
    """Read a rig: `.glb`, `.gltf`, `.vrm` (`gltf.read_rig`), USD, or a folder of OBJ or PLY (`read_rig_folder`).

    `tell` hears a line on what was assumed.

    Raises:
        BadInput: missing, neither, or what those raise.
    """
    path = existing(path)
    if path.is_dir():
        return read_rig_folder(path, unit, tell)
    if path.suffix.lower() in usd.SUFFIXES:
        return usd.read_rig(path, tell)
    if path.suffix.lower() in GLTF:
        return read_rig(path)
    raise BadInput(
        f"{path}: is no rig; give a .glb or .usd with blend shapes, or a folder of .obj or .ply, one named neutral"
    )


def write_any_rig(path: str | Path, rig: Rig) -> None:
    """Write a rig as its suffix says: `.glb` or USD.

    Raises:
        BadInput: another suffix, or no such folder.
    """
    suffix = Path(path).suffix.lower()
    if suffix != ".glb" and suffix not in usd.SUFFIXES:
        raise BadInput(f"{path}: a rig is written as {' or '.join(('.glb', *usd.SUFFIXES))}; name it so")
    write = usd.write_rig if suffix in usd.SUFFIXES else write_rig
    write(path, rig)


def read_rig_folder(folder: str | Path, unit: str | None = None, tell: Callable[[str], None] = _unheard) -> Rig:
    """A rig from a folder of meshes with the same vertices: the one named neutral and its shapes.

    Shapes are named after the files' stems, in alphabetical order. Faces, texture and colours are the neutral's. `unit`
    as in `read_scan`; by default the one of mm, m and cm in which the neutral has a face's size, which `tell` hears.

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
    unit = _settled(folder, read_scan(neutrals[0]), tell) if unit is None else unit
    neutral = read_scan(neutrals[0], unit)
    n = len(neutral.mesh.vertices)
    deltas = np.empty((len(targets), n, 3))
    for i, file in enumerate(targets):
        vertices = read_scan(file, unit).mesh.vertices
        if len(vertices) != n:
            raise BadInput(f"{file}: has {len(vertices)} vertices, {neutrals[0].name} {n}; export both from one mesh")
        deltas[i] = vertices - neutral.mesh.vertices
    return Rig(neutral.mesh, deltas, tuple(stems), neutral.texture)


def _settled(folder: Path, neutral: Scan, tell: Callable[[str], None]) -> str:
    """The unit in which the neutral's size is a face's; millimetres where none is."""
    span = float(np.linalg.norm(np.ptp(neutral.mesh.vertices, axis=0)))
    low, high = _FACE_MM
    unit = next((name for name in _TRIED if low <= span * UNITS[name] <= high), "mm")
    fits = low <= span * UNITS[unit] <= high
    if not fits:
        tell(f"{folder}: no unit makes a face of a size of {span:.4g}; read as mm (--units names another)")
    elif unit != "mm":
        tell(f"{folder}: read as {unit}, in which the neutral is {span * UNITS[unit]:.0f} mm across")
    return unit
