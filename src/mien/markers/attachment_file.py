"""Attachments by hand: a JSON file says where on the rig's neutral face each marker sits."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import BadInput
from ..files import existing, whole
from ..mesh import Attachment


def read_attachment(path: str | Path, labels: tuple[str, ...], faces: int) -> Attachment:
    """`{"LABEL": {"face": 12, "barycentric": [0.2, 0.3, 0.5]}, ...}` -> an Attachment in the order of `labels`.

    Args:
        faces: how many triangles the rig has.

    Raises:
        BadInput: no such file, not JSON, a marker without an entry, a triangle or weights that cannot be.
    """
    entries = read_entries(path)
    missing = [label for label in labels if label not in entries]
    if missing:
        raise BadInput(f"{path}: no place given for {', '.join(missing[:5])}; every marker of the take needs one")
    triangles, weights = [], []
    for label in labels:
        entry = entries[label]
        try:
            triangle, barycentric = int(entry["face"]), np.asarray(entry["barycentric"], dtype=float)
        except (TypeError, KeyError, ValueError, OverflowError):
            raise BadInput(f'{path}: {label}: expected {{"face": N, "barycentric": [a, b, c]}}, got {entry}') from None
        if not 0 <= triangle < faces:
            raise BadInput(f"{path}: {label}: triangle {triangle} is not among the rig's 0..{faces - 1}")
        if barycentric.shape != (3,) or not np.isclose(barycentric.sum(), 1, atol=1e-3) or (barycentric < -1e-6).any():
            raise BadInput(f"{path}: {label}: barycentric must be three weights >= 0 that add up to 1, got {entry}")
        triangles.append(triangle)
        weights.append(barycentric)
    return Attachment(np.array(triangles, dtype=np.int64), np.array(weights))


def labels_off_face(path: str | Path) -> tuple[str, ...]:
    """Markers that the file says are worn off the face: their entry is `null`."""
    return tuple(label for label, entry in read_entries(path).items() if entry is None)


def labels_on_face(path: str | Path) -> tuple[str, ...]:
    """Markers that the file places on the face."""
    return tuple(label for label, entry in read_entries(path).items() if entry is not None)


def write_attachment(
    path: str | Path, labels: tuple[str, ...], attachment: Attachment, off_face: tuple[str, ...] = ()
) -> None:
    """The file that `read_attachment` reads; markers worn off the face are `null`."""
    entries = dict.fromkeys(off_face) | {
        label: {"face": int(face), "barycentric": [round(float(w), 6) for w in weights]}
        for label, face, weights in zip(labels, attachment.faces, attachment.barycentric, strict=True)
    }
    with whole(path) as temporary:
        temporary.write_text(json.dumps(entries, indent=1) + "\n")


def entries_of(places: Mapping[str, Mapping[str, Any] | None]) -> dict[str, dict[str, Any] | None]:
    """What the file holds of each marker: its triangle and weights, or None off the face; anything else is left out."""
    kept = ("face", "barycentric")
    return {label: {key: place[key] for key in kept} if place else None for label, place in places.items()}


def read_entries(path: str | Path) -> dict:
    """The file as it stands: an entry a label.

    Raises:
        BadInput: no such file, or not JSON.
    """
    try:
        entries = json.loads(existing(path).read_text())
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not a JSON file ({error})") from None
    if not isinstance(entries, dict):
        raise BadInput(f'{path}: expected {{"LABEL": {{"face": N, "barycentric": [a, b, c]}}, ...}}')
    return entries
