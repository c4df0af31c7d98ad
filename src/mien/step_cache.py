"""Finished steps on disk: what was worked out once, by this code and from this input, is read, not worked out again."""

import hashlib
import importlib
import inspect
import json
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from .files import whole
from .progress import SILENT, Progress

T = TypeVar("T")

PACKAGE = __name__.rpartition(".")[0]
"""Dataclasses of this package alone are brought back."""
ABOVE = ("cli", "viewer", "experiments", "reports", "stage")
"""Rooms that no step of a system may import: a change in them leaves finished steps valid."""


class StepCache:
    """Runs steps and keeps what they give; tells progress to the steps that want it."""

    def __init__(self, folder: Path | None = None, progress: Progress = SILENT):
        """`folder` None: nothing is kept."""
        self.folder, self.progress = folder, progress

    def __call__(self, step: Callable[..., T], **inputs: Any) -> T:
        """`step(**inputs)`, from disk if this code was given equal inputs before.

        Inputs are what `fingerprint` takes; results arrays, numbers, strings, None, tuples, dicts and dataclasses
        of these. A step that has a parameter `progress` is given the cache's own.
        """
        wants = "progress" in inspect.signature(step).parameters
        told = {"progress": self.progress} if wants else {}
        if self.folder is None:
            return step(**inputs, **told)
        path = self.folder / f"{step.__name__}-{fingerprint((code_version(), inputs))}.npz"
        kept = _read(path)
        if kept is not None:
            return kept[0]
        made = step(**inputs, **told)
        _write(path, made)
        return (_read(path) or (made,))[0]  # arrays laid out as the next run will find them: sums depend on it

    def each(self, stage: str, step: Callable[..., T], many: list[dict[str, Any]]) -> list[T]:
        """The step on one set of inputs after the other; `stage` is what progress is told."""
        made = []
        for number, inputs in enumerate(many):
            self.progress.update(stage, number, len(many))
            made.append(self(step, **inputs))
        self.progress.update(stage, len(many), len(many))
        return made


@cache
def code_version() -> str:
    """A short name for the sources of the package below `ABOVE`: another one after every change of the code."""
    root, digest = Path(__file__).parent, hashlib.blake2b(digest_size=8)
    for path in sorted(root.rglob("*.py")):
        inside = path.relative_to(root)
        if inside.parts[0] not in ABOVE:
            digest.update(f"{inside.as_posix()};".encode() + path.read_bytes())
    return digest.hexdigest()


def fingerprint(inputs: object) -> str:
    """A short name for arrays, numbers, strings, dataclasses and what holds them: equal if they are equal."""
    digest = hashlib.blake2b(digest_size=8)
    _feed(digest, inputs)
    return digest.hexdigest()


def _feed(digest, value: object) -> None:
    if isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, (sp.sparray, sp.spmatrix)):
        entries = sp.csr_array(value)
        _feed(digest, (entries.shape, entries.indptr, entries.indices, entries.data))
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
    elif value is None or isinstance(value, (bool, int, float, str, bytes, Path, np.generic)):
        digest.update(repr(value).encode() + b";")
    else:
        raise TypeError(f"{type(value).__name__} has no fingerprint; give a step plain data")


def _read(path: Path) -> tuple[Any] | None:
    """The result in a file, in a tuple; None where there is none that can be read."""
    if not path.is_file():
        return None
    try:
        with path.open("rb") as file, np.load(file) as kept:
            arrays = dict(kept)
        return (_unpacked(json.loads(str(arrays.pop("tree"))), arrays),)
    except Exception:  # damaged bytes end numpy, zipfile and json in a dozen ways: the step is run again
        return None


def _write(path: Path, value: object) -> None:
    arrays: dict[str, np.ndarray] = {}
    tree = json.dumps(_packed(value, arrays))
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as temporary:
        np.savez(temporary, allow_pickle=False, tree=np.array(tree), **arrays)


def _packed(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    """A value as JSON; its arrays go to `arrays` and leave their names."""
    if isinstance(value, np.ndarray):
        name = f"a{len(arrays)}"
        arrays[name] = np.array(value, order="C")
        return {"array": name}
    if value is None or isinstance(value, (bool, int, float, str)):
        return {"plain": value}
    if isinstance(value, np.generic):
        return {"plain": value.item()}
    if isinstance(value, (list, tuple)):
        return {"list" if isinstance(value, list) else "tuple": [_packed(item, arrays) for item in value]}
    if isinstance(value, dict):
        return {"dict": {name: _packed(item, arrays) for name, item in value.items()}}
    if is_dataclass(value) and type(value).__module__.startswith(PACKAGE):
        parts = {field.name: _packed(getattr(value, field.name), arrays) for field in fields(value)}
        return {"class": [type(value).__module__, type(value).__name__], "fields": parts}
    raise TypeError(f"{type(value).__name__} cannot be kept; give back arrays, numbers, strings or dataclasses of them")


def _unpacked(tree: Any, arrays: dict[str, np.ndarray]) -> Any:
    """What `_packed` took apart."""
    if "array" in tree:
        return arrays[tree["array"]]
    if "plain" in tree:
        return tree["plain"]
    if "list" in tree:
        return [_unpacked(item, arrays) for item in tree["list"]]
    if "tuple" in tree:
        return tuple(_unpacked(item, arrays) for item in tree["tuple"])
    if "dict" in tree:
        return {name: _unpacked(item, arrays) for name, item in tree["dict"].items()}
    module, name = tree["class"]
    if not module.startswith(f"{PACKAGE}."):
        raise ValueError(f"{module}.{name} is none of ours")
    made: Any = getattr(importlib.import_module(module), name)
    if not (isinstance(made, type) and is_dataclass(made)):
        raise ValueError(f"{module}.{name} is no dataclass")
    return made(**{field: _unpacked(part, arrays) for field, part in tree["fields"].items()})
