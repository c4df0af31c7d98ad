"""Performances from and to files of any kind: glTF and USD."""

from collections.abc import Callable
from pathlib import Path

from ..errors import BadInput
from ..files import existing
from ..progress import unheard
from ..rig import Performance
from . import usd
from .gltf import read_performance, write_performance
from .rigs import GLTF

READ = (*GLTF, *usd.SUFFIXES)
WRITTEN = (".glb", *usd.SUFFIXES)


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
