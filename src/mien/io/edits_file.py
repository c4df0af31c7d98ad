"""`perf.edits.json` beside `perf.glb`: corrections that a new capture does not lose.

The capture is written again and again, the layer stays: whoever writes a performance applies the layer that lies beside
it, and keeps the capture itself as `perf.captured.glb`. `baked` in the layer says which file holds both, so that
nothing is applied twice.
"""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import BadInput
from ..files import whole
from ..progress import unheard
from ..rig import Performance
from ..rig.edits import FADE_S, Edits, Key, apply_edits
from .performances import read_any_performance, write_any_performance

SUFFIX = ".edits.json"
CAPTURED = ".captured"


def edits_beside(path: str | Path) -> Path:
    """Where the corrections of a performance's file are: perf.glb -> perf.edits.json."""
    return Path(path).with_suffix(SUFFIX)


def captured_beside(path: str | Path) -> Path:
    """Where the capture itself is kept: perf.glb -> perf.captured.glb."""
    path = Path(path)
    return path.with_name(f"{path.stem}{CAPTURED}{path.suffix}")


def edits_from(told: Any, source: str | Path) -> Edits:
    """The layer that JSON holds.

    Raises:
        BadInput: it is none; `source` is named.
    """
    try:
        keys = {
            str(name): tuple(sorted((Key(float(k["time"]), float(k["add"])) for k in some), key=lambda key: key.time))
            for name, some in told.get("keys", {}).items()
        }
        bad = tuple((float(span["from"]), float(span["to"])) for span in told.get("bad", []))
        return Edits({name: some for name, some in keys.items() if some}, bad, float(told.get("fade_s", FADE_S)))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{source}: is no layer of corrections ({error!r}); mend it or delete it") from error


def read_layer(path: str | Path) -> dict[str, Any]:
    """The JSON of a layer; empty where there is none.

    Raises:
        BadInput: it is no JSON.
    """
    path = Path(path)
    if not path.is_file():
        return {}
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise BadInput(f"{path}: is no JSON ({error}); mend it or delete it") from error
    edits_from(told, path)
    return told


def write_layer(path: str | Path, told: dict[str, Any]) -> None:
    """Write a layer, whole or not at all."""
    with whole(path) as temporary:
        temporary.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def read_captured(path: str | Path, tell: Callable[[str], None] = unheard) -> Performance:
    """The capture itself: where corrections are baked into `path`, from the file beside it.

    Raises:
        BadInput: as `read_any_performance` and `read_layer`.
    """
    baked = read_layer(edits_beside(path)).get("baked")
    kept = captured_beside(path)
    if baked and kept.is_file() and Path(path).is_file() and baked == _digest(path):
        return read_any_performance(kept, tell)
    return read_any_performance(path, tell)


def read_edited(path: str | Path, tell: Callable[[str], None] = unheard) -> Performance:
    """The capture with the corrections that lie beside it.

    Raises:
        BadInput: as `read_captured`.
    """
    edits = edits_from(read_layer(edits_beside(path)), edits_beside(path))
    performance = read_captured(path, tell)
    return _edited(path, performance, edits, tell) if len(edits) else performance


def write_edited(path: str | Path, performance: Performance, tell: Callable[[str], None] = unheard) -> None:
    """Write a new capture; corrections that lie beside it are applied, and the capture is kept beside it.

    Raises:
        BadInput: as `write_any_performance` and `read_layer`.
    """
    layer = read_layer(edits_beside(path))
    edits = edits_from(layer, edits_beside(path))
    if not len(edits):
        write_any_performance(path, performance)
        return
    edited = _edited(path, performance, edits, tell)
    write_any_performance(captured_beside(path), performance)
    write_any_performance(path, edited)
    write_layer(edits_beside(path), layer | {"baked": _digest(path)})


def _edited(path: str | Path, performance: Performance, edits: Edits, tell: Callable[[str], None]) -> Performance:
    beside = edits_beside(path)
    edited, unknown = apply_edits(performance, edits)
    tell(f"{beside}: {len(edits)} corrections applied")
    if unknown:
        tell(f"{beside}: left out {', '.join(unknown)}: the rig has no such shape")
    return edited


def _digest(path: str | Path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()
