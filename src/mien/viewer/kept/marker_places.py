"""Where markers sit on the skin, what they are called and when they are bad: moved in the page, used by the next solve.

Places go into `perf.attach.json`, which `mien solve --attach` reads; names and bad ranges into `take.markers.json`.
"""

import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from ...clip import Markers
from ...errors import BadInput
from ...files import whole
from ...io.markers.marker_edits import apply_marker_edits, marker_edits_from, read_marker_edits, write_marker_edits
from ...markers.attachment_file import entries_of, read_entries
from ...markers.inputs import face_from_rig
from ...mesh import ClosestPoint, submesh
from ...rig import Performance
from ..marker_overlay import markers_in_world
from ..server import Answer

SUFFIX = ".attach.json"
TRIED = 24
"""Frames in which a marker is looked for, the calmest first."""
OFF_FACE_MM = 30.0
"""Markers that are farther from the skin are worn off the face: head bands, rigid bodies."""
STALE = "markers were changed elsewhere since; they are loaded anew"
"""What the second of two pages is told."""


@dataclass(frozen=True)
class SolvedTake:
    """A take as its file has it (`read_marker_file(..., as_filed=True)`), and the performance solved from it."""

    markers: Markers
    take: Path
    performance: Performance
    solved: Path


class MarkerPlaces:
    """Markers of a page; a revision counts up, so that two pages do not overwrite each other."""

    def __init__(self, shown: Callable[[], SolvedTake]):
        """`shown` gives what the page shows by now: the performance is another one after a rerun."""
        self._ask = shown
        self._lock = threading.Lock()
        self._revision = 0
        self.labels = shown().markers.labels

    @property
    def _shown(self) -> SolvedTake:
        return self._ask()

    @property
    def attach_file(self) -> Path:
        """perf.glb -> perf.attach.json."""
        return self._shown.solved.with_suffix(SUFFIX)

    def read(self, asked: Mapping[str, str]) -> Answer:
        """Labels, places, names and bad ranges."""
        edits = read_marker_edits(self._shown.take)
        kept = read_entries(self.attach_file) if self.attach_file.is_file() else {}
        places = {}
        for label in self.labels:
            name = edits.names.get(label, label)
            place = kept.get(name, kept.get(label, self._found[label]))
            places[label] = place and place | {"corners": self._corners(place["face"])}
        bad = {label: [{"from": a, "to": b} for a, b in spans] for label, spans in edits.bad.items()}
        told = {"labels": self.labels, "places": places, "names": dict(edits.names), "bad": bad}
        return Answer.json(told | {"revision": self._revision})

    def place(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """The skin nearest to a point, face space, mm, of the face under the weights that the page shows."""
        told: dict[str, Any] = json.loads(body)
        weights, point = np.array(told["weights"], float), np.array(told["point"], float)
        if weights.shape != (len(self._rig.names),) or point.shape != (3,):
            raise BadInput("place: expected a point (3) and a weight a shape")
        entry = self._nearest(self._rig.vertices(weights), point[None])[1][0]
        return Answer.json(entry | {"corners": self._corners(entry["face"])})

    def save(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Keep places, names and bad ranges.

        Raises:
            BadInput: two markers of one name, a place that cannot be.
        """
        told: dict[str, Any] = json.loads(body)
        edits = marker_edits_from(told, "the page")
        apply_marker_edits(self._shown.markers, edits, "the page")
        entries = {edits.names.get(label, label): told["places"][label] for label in self.labels}
        with self._lock:
            if told.get("revision") != self._revision:
                return Answer.stale(STALE)
            with whole(self.attach_file) as temporary:
                temporary.write_text(json.dumps(entries_of(entries), indent=1) + "\n", encoding="utf-8")
            write_marker_edits(self._shown.take, edits)
            self._revision += 1
        again = f"mien solve {self._shown.take} --attach {self.attach_file}"
        return Answer.json({"revision": self._revision, "rerun": again})

    @property
    def _rig(self):
        return self._shown.performance.rig

    @cached_property
    def _found(self) -> dict[str, dict[str, Any] | None]:
        """Places by the solved performance: under each marker in the calmest frame that shows it."""
        performance = self._shown.performance
        world = markers_in_world(self._shown.markers, performance)
        seconds = min(len(world) / self._shown.markers.rate, len(performance) / performance.rate)
        times = np.linspace(0, seconds, TRIED, endpoint=False)
        effort = [float(np.abs(performance.weights[int(t * performance.rate)]).sum()) for t in times]
        found: dict[str, dict[str, Any] | None] = dict.fromkeys(self.labels)
        for time in times[np.argsort(effort, kind="stable")]:
            frame = int(time * performance.rate)
            points = performance.T_world_face[frame].inverse().apply(world[int(time * self._shown.markers.rate)])
            open_ = [m for m, label in enumerate(self.labels) if found[label] is None and np.isfinite(points[m]).all()]
            if open_:
                distances, entries = self._nearest(self._rig.vertices(performance.weights[frame]), points[open_])
                near = distances <= OFF_FACE_MM
                found |= {self.labels[m]: entries[i] for i, m in enumerate(open_) if near[i]}
        return found

    def _nearest(
        self, vertices: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "q 3"]
    ) -> tuple[Float[np.ndarray, " q"], list[dict[str, Any]]]:
        """Distances, mm, and entries of the attachment's file."""
        skin, old, triangles = self._skin
        closest = ClosestPoint(skin.with_vertices(vertices[old])).query(points)
        entries = [
            {"face": int(triangles[face]), "barycentric": np.clip(weights, 0, 1).round(6).tolist()}
            for face, weights in zip(closest.faces, closest.barycentric, strict=True)
        ]
        return closest.distances, entries

    @cached_property
    def _skin(self):
        """The skin's mesh, its vertices' numbers and its triangles' numbers in the rig."""
        mesh = self._rig.neutral
        triangles = face_from_rig(self._rig).skin_faces
        return *submesh(mesh, triangles), triangles

    def _corners(self, face: int) -> list[int]:
        return self._rig.neutral.faces[face].tolist()
