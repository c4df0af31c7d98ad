"""Finished work on disk: what was worked out once from the same input is read, not worked out again."""

import hashlib
import zipfile
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

from .files import whole


class Store:
    """Arrays by stage and input; in a folder, or (`None`) nowhere."""

    def __init__(self, folder: Path | None):
        self.folder = folder

    def get(self, stage: str, inputs: object, make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
        """What `make` gives, from disk if it was made before from the same `inputs` (see `fingerprint`)."""
        if self.folder is None:
            return make()
        path = self.folder / f"{stage}-{fingerprint(inputs)}.npz"
        if path.is_file():
            try:
                with np.load(path) as kept:
                    return dict(kept)
            except (ValueError, OSError, zipfile.BadZipFile):
                pass
        made = {name: np.array(value, order="C") for name, value in make().items()}
        self.folder.mkdir(parents=True, exist_ok=True)
        with whole(path) as temporary:
            np.savez(temporary, allow_pickle=False, **made)
        return made


def fingerprint(inputs: object) -> str:
    """A short name for arrays, numbers, strings, dataclasses and what holds them: equal if they are equal."""
    digest = hashlib.blake2b(digest_size=8)
    _feed(digest, inputs)
    return digest.hexdigest()


def _feed(digest, value: object) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif is_dataclass(value) and not isinstance(value, type):
        digest.update(type(value).__name__.encode())
        for field in fields(value):
            _feed(digest, getattr(value, field.name))
    elif isinstance(value, (list, tuple)):
        digest.update(f"{len(value)}(".encode())
        for item in value:
            _feed(digest, item)
    elif isinstance(value, dict):
        _feed(digest, sorted(value.items()))
    else:
        digest.update(repr(value).encode() + b";")
