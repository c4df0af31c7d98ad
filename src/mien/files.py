"""Outputs appear whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import BadInput


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it to `path` if the block ends well, else remove it.

    The temporary name keeps the suffix, since many writers choose their format by it.

    Raises:
        BadInput: the folder of `path` does not exist.
    """
    path = Path(path)
    writable(path)
    temporary = path.with_name(f".{path.stem}.mien-tmp{os.getpid()}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def writable(*paths: str | Path) -> None:
    """Before long work: the folders that its outputs go to exist.

    Raises:
        BadInput: one does not.
    """
    for path in map(Path, paths):
        if not path.parent.is_dir():
            raise BadInput(f"{path}: the folder {path.parent} does not exist; create it first")


def existing(path: str | Path) -> Path:
    """`path` as a Path, or BadInput where nothing stands there."""
    path = Path(path)
    if not path.exists():
        raise BadInput(f"{path}: no such file or folder")
    return path
