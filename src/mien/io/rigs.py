"""Rigs from and to files of any kind: glTF, USD, a folder of meshes that share their vertices."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..files import existing
from ..mesh import Scan
from ..progress import unheard
from ..rig import Rig
from ..units import UNITS
from . import usd
from .gltf import read_rig, write_rig
from .meshes import read_scan

SUFFIXES = (".obj", ".ply")
GLTF = (".glb", ".gltf", ".vrm")
_FACE_MM = (130.0, 900.0)
"""Box diagonals that are taken for a face or a head with its neck: of mm, m and cm only one can fit."""
_TRIED = {**UNITS, "dm": 100.0}
"""Millimetres in one of the units that are tried; the face's sizes in them hardly overlap, and the first that fits is
taken (decimetres are MakeHuman's)."""
_NEUTRAL_WORDS = (("neutral",), ("base", "basis", "rest", "default", "bind", "relaxed", "calm", "idle"))
"""What the mesh without expression is called: a word of its name. The later ones count where no name has the first."""
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+")


_LISTED = 4
"""Files named in a message."""


def read_any_rig(path: str | Path, unit: str | None = None, tell: Callable[[str], None] = unheard) -> Rig:
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


def read_rig_folder(folder: str | Path, unit: str | None = None, tell: Callable[[str], None] = unheard) -> Rig:
    """A rig from a folder of meshes with the same vertices: the one named neutral and its shapes.

    Shapes are named after the files' stems, in alphabetical order. Faces, texture and colours are the neutral's. `unit`
    as in `read_scan`; by default the one in which the neutral has a face's size, which `tell` hears. A mesh that cannot
    be read, or of another vertex count, is left out, which `tell` hears too.

    Raises:
        BadInput: no or several neutrals, no other mesh that can be used.
    """
    folder = existing(folder)
    visible = [file for file in folder.iterdir() if not file.name.startswith(".")]
    files = sorted(file for file in visible if file.suffix.lower() in SUFFIXES)
    resting = _neutral_of(folder, files)
    targets = [file for file in files if file != resting]
    stems = [file.stem for file in targets]
    if not targets or len(set(stems)) < len(stems):
        problem = "two meshes of one name" if targets else f"no mesh beside {resting.name}"
        raise BadInput(f"{folder}: has {problem}; put one .obj or .ply for every shape there")
    unit = _settled(folder, read_scan(resting), tell) if unit is None else unit
    neutral = read_scan(resting, unit)
    deltas, faults = {}, []
    for file in targets:
        try:
            deltas[file.stem] = _delta(file, unit, neutral, resting)
        except BadInput as error:
            faults.append(error)
    if not deltas:
        raise faults[0]
    for fault in faults:
        tell(f"left out: {fault}")
    return Rig(neutral.mesh, np.stack(list(deltas.values())), tuple(deltas), neutral.texture)


def _neutral_of(folder: Path, files: list[Path]) -> Path:
    """The mesh whose name says that it is without expression.

    Raises:
        BadInput: none says so, or several do.
    """
    words = {file: {word.lower() for word in _WORD.findall(file.stem)} for file in files}
    for names in _NEUTRAL_WORDS:
        found = [file for file in files if words[file] & set(names) or file.stem.lower().startswith(names)]
        if len(found) == 1:
            return found[0]
        if found:
            several = ", ".join(file.name for file in found)
            raise BadInput(f"{folder}: needs exactly one .obj or .ply named neutral, has {several}")
    some = ", ".join(file.name for file in files[:_LISTED]) or "no .obj or .ply at all"
    raise BadInput(f"{folder}: needs exactly one .obj or .ply named neutral, has {some}")


def _delta(file: Path, unit: str, neutral: Scan, resting: Path) -> Float[np.ndarray, "n 3"]:
    """A shape's displacements from the neutral, mm.

    Raises:
        BadInput: what `read_scan` raises, or another vertex count.
    """
    vertices = read_scan(file, unit).mesh.vertices
    n = len(neutral.mesh.vertices)
    if len(vertices) != n:
        raise BadInput(f"{file}: has {len(vertices)} vertices, {resting.name} {n}; export both from one mesh")
    return vertices - neutral.mesh.vertices


def _settled(folder: Path, neutral: Scan, tell: Callable[[str], None]) -> str:
    """The unit in which the neutral's size is a face's; millimetres where none is."""
    span = float(np.linalg.norm(np.ptp(neutral.mesh.vertices, axis=0)))
    low, high = _FACE_MM
    unit = next((name for name, mm in _TRIED.items() if low <= span * mm <= high), "mm")
    mm = _TRIED[unit]
    if not low <= span * mm <= high:
        tell(f"{folder}: no unit makes a face of a size of {span:.4g}; read as mm (--units names another)")
    elif unit != "mm":
        tell(f"{folder}: read as {unit}, in which the neutral is {span * mm:.0f} mm across")
    return f"{mm:g}"
