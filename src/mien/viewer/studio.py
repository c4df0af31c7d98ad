"""What the page talks to: the scene, its files, and what is corrected there."""

import contextlib
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from ..clip import Markers
from ..errors import BadInput
from ..io.rigs import GLTF
from ..mesh import Scan
from ..rig import Performance
from ..units import parse_unit
from .kept.clicked_pairs import ClickedPairs, ViewedScan
from .kept.corrections import Corrections
from .kept.film_out import FilmOut
from .kept.map_marks import MapMarks
from .kept.marker_places import MarkerPlaces, SolvedTake
from .live_feed import LiveFeed
from .open_files import MAP, reopened
from .server import MIMES, Answer, PageServer, Routes, open_server
from .studio_scene import Film, Shown, pack_scene


class Studio:
    """Things to be shown and the routes of their page."""

    def __init__(self, shown: Sequence[Shown], films: Sequence[Film] = (), live: LiveFeed | None = None):
        """`live` moves the first face as it is tracked."""
        self._live = live
        self.shown, self.films = tuple(shown), tuple(films)
        self._packed: bytes | None = None
        self._stamp = self.stamp()
        self._lock = threading.Lock()

    def scene(self) -> bytes:
        """The scene file, packed once; and again where a file was written anew, if it can be read."""
        with self._lock:
            stamp = self.stamp()
            if stamp != self._stamp:
                self._stamp = stamp
                with contextlib.suppress(BadInput, OSError):
                    again = tuple(reopened(one) for one in self.shown)
                    self._packed = pack_scene(again, self.films, self._live is not None)
                    self.shown = again
            if self._packed is None:
                self._packed = pack_scene(self.shown, self.films, self._live is not None)
            return self._packed

    def stamp(self) -> str:
        """When the files were last written."""
        paths = [one.path for one in self.shown if one.path is not None]
        return " ".join(str(path.stat().st_mtime_ns) if path.exists() else "away" for path in paths)

    def routes(self) -> Routes:
        """What the page can ask for."""
        routes = Routes()
        corrections = Corrections(self._corrected())
        routes.get["/edits"] = corrections.read
        routes.post["/edits"] = corrections.save
        if self._live is not None:
            self._live.add_routes(routes)
        routes.get["/stamp"] = lambda _: Answer(self.stamp().encode(), "text/plain")
        beside = next((one.path for one in self.shown if one.path is not None), None)
        if beside is not None:
            film = FilmOut(beside)
            routes.post |= {"/film": film.add, "/film-done": film.finish}
        if self._solved() is not None:
            markers = MarkerPlaces(lambda: cast(SolvedTake, self._solved()))
            routes.get["/markers"] = markers.read
            routes.post |= {"/markers": markers.save, "/marker-place": markers.place}
        maps = [path for path in (one.path for one in self.shown) if path is not None and path.suffix.lower() == MAP]
        if maps:
            marks = MapMarks(maps)
            routes.get |= {"/map": marks.read, "/map-picture": marks.picture, "/map-landmarks": marks.landmarks}
            routes.post["/map"] = marks.save
        scans = self._scans()
        if len(scans) > 1:
            pairs = ClickedPairs(scans)
            routes.get["/constraints"] = pairs.read
            routes.post["/constraints"] = pairs.save
        routes.get["/scene.bin"] = lambda _: Answer(self.scene())
        for i, film in enumerate(self.films):
            routes.get[f"/media/{i}{film.path.suffix}"] = lambda _, film=film: Answer(
                film.path.read_bytes(), MIMES.get(film.path.suffix.lower(), "video/mp4")
            )
        return routes

    def _solved(self) -> SolvedTake | None:
        """The first take and the first performance, where both came from files."""
        take = next((one for one in self.shown if isinstance(one.thing, Markers)), None)
        face = next((one for one in self.shown if isinstance(one.thing, Performance)), None)
        if take is None or face is None or take.path is None or face.path is None:
            return None
        assert isinstance(take.thing, Markers)
        assert isinstance(face.thing, Performance)
        return SolvedTake(take.thing, take.path, face.thing, face.path)

    def _scans(self) -> list[ViewedScan]:
        """Scans that came from files; maps have marks of their own."""
        scans = [one for one in self.shown if isinstance(one.thing, Scan)]
        paths = [(one.path, one.units) for one in scans if one.path is not None and one.path.suffix.lower() != MAP]
        return [ViewedScan(path, _unit_mm(path, units)) for path, units in paths]

    def _corrected(self) -> dict[int, Path]:
        """Performances that came from files, by their number among the page's faces."""
        faces = [one for one in self.shown if not isinstance(one.thing, Markers)]
        moving = {i: one.path for i, one in enumerate(faces) if isinstance(one.thing, Performance)}
        return {i: path for i, path in moving.items() if path is not None}

    def open(self, host: str, port: int | None = None) -> PageServer:
        """Serve the page from a thread of its own.

        Raises:
            BadInput: as `open_server`.
        """
        self.scene()
        server = open_server(self.routes(), host, port)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        return server


def _unit_mm(path: Path, units: str | None) -> float:
    """Millimetres in one unit of a scan's file; glTF says its own."""
    return 1.0 if units is None or path.suffix.lower() in GLTF else parse_unit(units)
