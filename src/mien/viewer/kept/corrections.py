"""Corrections that the page saves, at once and whole."""

import json
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import BadInput
from ...io.edits_file import edits_beside, edits_from, read_layer, write_layer
from ..server import Answer

STALE = "corrections were changed elsewhere since; they are loaded anew"
"""What the second of two pages is told."""


class Corrections:
    """The layers beside the faces of a page; a revision counts up, so that two pages do not overwrite each other."""

    def __init__(self, files: Mapping[int, Path]):
        self._files = dict(files)
        self._lock = threading.Lock()

    def read(self, asked: Mapping[str, str]) -> Answer:
        """The layer of face `face`."""
        return Answer.json(read_layer(self._beside(asked)))

    def save(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Keep a layer; refused where its revision is not the one that lies there.

        Raises:
            BadInput: it is no layer.
        """
        path = self._beside(asked)
        told: dict[str, Any] = json.loads(body)
        edits_from(told, "the page")
        with self._lock:
            before = read_layer(path)
            if told.get("revision", 0) != before.get("revision", 0):
                return Answer.stale(STALE)
            kept = before | told | {"revision": before.get("revision", 0) + 1}
            write_layer(path, kept)
        return Answer.json({"revision": kept["revision"], "file": path.name})

    def _beside(self, asked: Mapping[str, str]) -> Path:
        number = asked.get("face", "")
        if not number.isdigit() or int(number) not in self._files:
            raise BadInput(f"face {number!r}: there is none whose corrections are kept")
        return edits_beside(self._files[int(number)])
