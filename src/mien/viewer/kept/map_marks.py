"""What is said by hand of captures' maps: landmarks moved, added or dropped, pins, and masks that are painted.

Kept in `corrections.json` beside the maps, masks as `corrections/NAME.png`: what `mien rig --corrections` reads.
"""

import base64
import io
import json
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ...blendshapes.corrections import read_corrections, write_corrections
from ...blendshapes.correspond.landmarks import landmarks_on_map
from ...blendshapes.cylinder_map import CylinderMap
from ...blendshapes.map_file import read_map
from ...errors import BadInput
from ...files import whole
from ..server import Answer

FILE, MASKS = "corrections.json", "corrections"
"""Masks lie in a folder of their own: a picture beside a mesh could pass for its texture."""
STALE = "this map was changed elsewhere since; it is loaded anew"
"""What the second of two pages is told."""
NOTHING_SEEN = (38, 39, 42)
"""sRGB where a map has no surface."""
PNG_URL = "data:image/png;base64,"


class MapMarks:
    """The maps of a page; a revision of each counts up, so that two pages do not overwrite each other."""

    def __init__(self, paths: Sequence[Path]):
        self._paths = {path.name: path for path in paths}
        self._maps: dict[str, CylinderMap] = {}
        self._found: dict[str, dict[int, list[float]]] = {}
        self._revisions = dict.fromkeys(self._paths, 0)
        self._lock = threading.Lock()

    def read(self, asked: Mapping[str, str]) -> Answer:
        """A map's size and what is said of it by hand; the mask as a picture's address, "" where there is none."""
        path = self._path(asked)
        part = self._told(path).get(path.stem, {})
        height, width = self._map(path).layout.shape
        mask = PNG_URL + base64.b64encode((path.parent / part["mask"]).read_bytes()).decode() if "mask" in part else ""
        said = {"landmarks": part.get("landmarks", {}), "pins": part.get("pins", {}), "mask": mask}
        return Answer.json(said | {"width": width, "height": height, "revision": self._revisions[path.name]})

    def picture(self, asked: Mapping[str, str]) -> Answer:
        """A map's colours."""
        map_ = self._map(self._path(asked))
        shown = np.where(map_.known[..., None], np.nan_to_num(map_.colors) * 255, NOTHING_SEEN)
        buffer = io.BytesIO()
        Image.fromarray(shown.round().clip(0, 255).astype(np.uint8)).save(buffer, format="png")
        return Answer(buffer.getvalue(), "image/png")

    def landmarks(self, asked: Mapping[str, str]) -> Answer:
        """Landmarks that are found on a map, pixels by MediaPipe's number.

        Raises:
            BadInput: no face is found, or landmarks cannot be looked for on this machine.
        """
        path = self._path(asked)
        with self._lock:
            if path.name not in self._found:
                map_ = self._map(path)
                found = landmarks_on_map(map_)
                pixels = found.pixels(map_.layout)
                self._found[path.name] = {int(i): pixels[i].round(2).tolist() for i in np.flatnonzero(found.known)}
        return Answer.json(self._found[path.name])

    def save(self, body: bytes, asked: Mapping[str, str]) -> Answer:
        """Keep what is said of a map.

        Raises:
            BadInput: it is none of what `mien rig --corrections` reads.
        """
        path, said = self._path(asked), json.loads(body)
        with self._lock:
            if said.get("revision") != self._revisions[path.name]:
                return Answer.stale(STALE)
            told = self._told(path)
            part = {key: said[key] for key in ("landmarks", "pins") if said.get(key)} | self._masked(path, said)
            told.pop(path.stem, None)
            write_corrections(path.parent / FILE, told | ({path.stem: part} if part else {}))
            self._revisions[path.name] += 1
        again = f"mien rig {path.parent} --corrections {path.parent / FILE}"
        return Answer.json({"revision": self._revisions[path.name], "rerun": again})

    def _masked(self, path: Path, said: Mapping[str, Any]) -> dict[str, str]:
        """The mask written, and what the file says of it."""
        mask = path.parent / MASKS / f"{path.stem}.png"
        if not said.get("mask"):
            mask.unlink(missing_ok=True)
            return {}
        data = base64.b64decode(said["mask"].removeprefix(PNG_URL))
        size, (height, width) = Image.open(io.BytesIO(data)).size, self._map(path).layout.shape
        if size != (width, height):
            raise BadInput(f"mask of {path.name}: is {size[0]} x {size[1]} pixels; the map has {width} x {height}")
        mask.parent.mkdir(exist_ok=True)
        with whole(mask) as temporary:
            temporary.write_bytes(data)
        return {"mask": f"{MASKS}/{mask.name}"}

    def _told(self, path: Path) -> dict[str, Any]:
        """The file beside a map; empty where there is none."""
        file = path.parent / FILE
        if not file.is_file():
            return {}
        read_corrections(file)
        return json.loads(file.read_text(encoding="utf-8"))

    def _map(self, path: Path) -> CylinderMap:
        if path.name not in self._maps:
            self._maps[path.name] = read_map(path)
        return self._maps[path.name]

    def _path(self, asked: Mapping[str, str]) -> Path:
        name = asked.get("map", "")
        if name not in self._paths:
            raise BadInput(f"map {name!r}: the page shows none of that name")
        return self._paths[name]
