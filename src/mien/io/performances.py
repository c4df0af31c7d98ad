"""Performances from and to files of any kind: glTF and USD."""

from collections.abc import Callable
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from ..mesh import Scan
from ..progress import unheard
from ..rig import Performance, Rig
from . import usd
from .gltf import read_performance, write_performance
from .gltf.glb import open_glb
from .rigs import GLTF

READ = (*GLTF, *usd.SUFFIXES)
WRITTEN = (".glb", *usd.SUFFIXES)


def face_kind(path: str | Path) -> type[Performance] | type[Rig] | type[Scan]:
    """What a glTF or USD file holds, by its index alone: a performance, a rig without motion, a mesh without shapes.

    Raises:
        BadInput: missing, damaged, or a USD without shapes.
    """
    if Path(path).suffix.lower() in usd.SUFFIXES:
        return Performance if usd.is_animated(path) else Rig
    content = open_glb(path).json
    parts = [part for mesh in content.get("meshes", []) for part in mesh.get("primitives", [])]
    if not any("targets" in part for part in parts):
        return Scan
    return Performance if content.get("animations") else Rig


def read_any_performance(path: str | Path, tell: Callable[[str], None] = unheard) -> Performance:
    """A performance from `.glb`, `.gltf`, `.vrm` (`gltf.read_performance`) or USD (`usd.read_performance`).

    `tell` hears what was left out.

    Raises:
        BadInput: another suffix, or what those raise.
    """
    path = existing(path)
    suffix = path.suffix.lower()
    if suffix in usd.SUFFIXES:
        return usd.read_performance(path, tell)
    if suffix in GLTF:
        return read_performance(path)
    raise BadInput(f"{path}: is no animated face; give one of {' '.join(READ)}")


def write_any_performance(path: str | Path, performance: Performance) -> None:
    """Write a performance as its suffix says: `.glb` or USD.

    Raises:
        BadInput: another suffix, or no such folder.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in WRITTEN:
        raise BadInput(f"{path}: an animated face is written as {' or '.join(WRITTEN)}; name it so")
    write = usd.write_performance if suffix in usd.SUFFIXES else write_performance
    write(path, performance)
