"""Outputs appear whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from .errors import BadInput


@dataclass
class Written:
    """What a command wrote."""

    paths: list[Path] = field(default_factory=list)
    """In order."""
    clocks: dict[Path, tuple[float, int]] = field(default_factory=dict)
    """Frames a second and frames, of those that move."""


_WRITTEN: ContextVar[Written | None] = ContextVar("written", default=None)


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` if the block ends well, else remove it.

    The temporary name keeps the suffix, since many writers choose their format by it.

    Raises:
        BadInput: the folder of `path` does not exist, or `path` is a folder.
    """
    path = Path(path)
    _place(path)
    temporary = _beside(path)
    try:
        yield temporary
        os.replace(temporary, path)
        _note(path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def recorded() -> Iterator[Written]:
    """What `whole` writes while the block runs."""
    written = Written()
    before = _WRITTEN.set(written)
    try:
        yield written
    finally:
        _WRITTEN.reset(before)


def note_clock(path: str | Path, rate: float, frames: int) -> None:
    """Say of a file just written how many frames it has, and how many a second."""
    written = _WRITTEN.get()
    if written is not None:
        written.clocks[Path(path)] = rate, frames


def writable(*paths: str | Path) -> None:
    """Before long work: files may be written where its outputs go, tried with an empty one.

    Raises:
        BadInput: a folder is missing or may not be written, or a path is a folder itself or write-protected.
    """
    for path in map(Path, paths):
        _place(path)
        try:
            _beside(path).touch(exist_ok=False)
            _beside(path).unlink()
        except OSError as error:
            raise BadInput(f"{path}: cannot be written there: {error.strerror}; choose another place") from error
        if path.exists() and not os.access(path, os.W_OK):
            raise BadInput(f"{path}: is there and write-protected; choose another name")


def writable_folder(path: str | Path) -> None:
    """The same for a folder, which may be missing: the nearest that is there is tried.

    Raises:
        BadInput: it may not be written, or is a file.
    """
    path = Path(path)
    there = next(p for p in (path, *path.absolute().parents) if p.exists())
    if not there.is_dir():
        raise BadInput(f"{there}: is a file; name a folder")
    writable(there / "probe")


def existing(path: str | Path) -> Path:
    """`path` as a Path, or BadInput where nothing stands there."""
    path = Path(path)
    if not path.exists():
        raise BadInput(f"{path}: no such file or folder")
    return path


def _note(path: Path) -> None:
    written = _WRITTEN.get()
    if written is not None:
        written.paths.append(path)


def _place(path: Path) -> None:
    if path.is_dir():
        raise BadInput(f"{path}: is a folder; name a file")
    if not path.parent.is_dir():
        raise BadInput(f"{path}: the folder {path.parent} does not exist; create it first")


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.stem}.mien-tmp{os.getpid()}{path.suffix}")
