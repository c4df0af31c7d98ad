"""Points and lines that the page's user says are the same on two scans: `constraints.json` beside the scans."""

import json
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import BadInput
from ...files import whole
from ...image_space.constraints import read_constraints
from ..server import Answer

FILE = "constraints.json"
"""What `mien register --constraints` reads (`image_space.constraints`)."""


@dataclass(frozen=True)
class ViewedScan:
    """A scan of the page."""

    path: Path
    unit_mm: float
    """Millimetres in one unit of its file: the page has millimetres, `constraints.json` the file's units."""


class ClickedPairs:
    """The pairs of the page's scans among those of the file."""

    def __init__(self, scans: Sequence[ViewedScan]):
        self._scans = {scan.path.name: scan for scan in scans}
        self._file = scans[0].path.parent / FILE
        self._lock = threading.Lock()

    def read(self, asked: Mapping[str, str]) -> Answer:
        """The pairs, in millimetres.

        Raises:
            BadInput: the file is none of ours.
        """
        pairs = [self._scaled(pair, to_file=False) for pair in self._pairs() if self._known(pair)]
        return Answer.json({"pairs": pairs})

    def save(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Keep what two scans of the page have in common, in place of what they had; other pairs stay.

        Raises:
            BadInput: other scans, or no pair.
        """
        told: dict[str, Any] = json.loads(body)
        if not self._known(told):
            raise BadInput(f"scans: expected two of {', '.join(self._scans)}, got {told.get('scans')}")
        with self._lock:
            others = [pair for pair in self._pairs() if pair["scans"] != told["scans"]]
            mine = [self._scaled(told, to_file=True)] if told["points"] or told["curves"] else []
            with whole(self._file) as temporary:
                temporary.write_text(json.dumps({"pairs": others + mine}, indent=1) + "\n", encoding="utf-8")
                read_constraints(temporary)
        return Answer(f"Saved; rerun mien register with --constraints {self._file}".encode(), "text/plain")

    def _pairs(self) -> list[dict[str, Any]]:
        if not self._file.is_file():
            return []
        read_constraints(self._file)
        return json.loads(self._file.read_text(encoding="utf-8"))["pairs"]

    def _known(self, pair: Mapping[str, Any]) -> bool:
        return len(pair.get("scans", ())) == 2 and all(name in self._scans for name in pair["scans"])

    def _scaled(self, pair: Mapping[str, Any], to_file: bool) -> dict[str, Any]:
        """Places by their scan's unit."""
        units = [self._scans[name].unit_mm for name in pair["scans"]]
        sides = [1 / unit if to_file else unit for unit in units]
        points = [[_times(place, k) for place, k in zip(both, sides, strict=True)] for both in pair.get("points", [])]
        curves = [
            [[_times(place, k) for place in line] for line, k in zip(both, sides, strict=True)]
            for both in pair.get("curves", [])
        ]
        return {"scans": pair["scans"], "points": points, "curves": curves}


def _times(place: Sequence[float], factor: float) -> list[float]:
    return [float(x) * factor for x in place]
