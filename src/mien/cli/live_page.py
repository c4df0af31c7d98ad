"""The page that shows a face while it is tracked: shared by `track` and `stream`."""

import sys
import time
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from ..depth import RGBDFrame
from ..rgbd import RgbdTake, write_rgbd
from ..rig import Rig
from ..tracking.pipeline import T_WORLD_CAMERA, TrackResult
from ..viewer.live_feed import LiveFeed
from ..viewer.server import LOCAL
from ..viewer.studio import Studio
from ..viewer.studio_scene import Shown
from .play import tell


class LivePage:
    """A page, the take that it watches, and what hears the tracker."""

    def __init__(self, take: RgbdTake, rig: Rig):
        self._plain = take
        self.feed = LiveFeed(self._keep)
        self.take = self.feed.watched(take)
        self._studio = Studio([Shown(take.name, rig)], live=self.feed)

    def watch(self, result: TrackResult) -> None:
        """A frame's outcome to the page."""
        pose = T_WORLD_CAMERA @ result.T_camera_face
        self.feed.show(result.weights, pose, result.tracked)

    def watched(self, results: Iterator[TrackResult]) -> Iterator[TrackResult]:
        """The same outcomes, shown as they pass; with the neutral that the page calibrated."""
        for result in results:
            self.watch(result)
            weights = self.feed.calibrated(result.weights)
            yield replace(result, weights=weights)

    @contextmanager
    def open(self) -> Iterator[None]:
        """The page is up while the block runs."""
        server = self._studio.open(LOCAL)
        tell(f"the face moves at {server.address}")
        if sys.stdout.isatty():
            webbrowser.open(server.address)
        try:
            yield
        finally:
            server.shutdown()
            server.server_close()

    def _keep(self, frames: list[RGBDFrame]) -> str:
        """A recording as an RGB-D folder that `mien track` reads."""
        folder = Path(time.strftime("take-%Y%m%d-%H%M%S"))
        first = frames[0].time
        kept = [replace(frame, time=frame.time - first) for frame in frames]
        take = replace(self._plain, name=folder.name, count=len(kept), frames=lambda: iter(kept))
        write_rgbd(folder, take, color="jpg")
        tell(f"recorded {folder}/: {len(kept)} frames")
        return f"recorded {folder}/: {len(kept)} frames; mien track {folder}/ reads it"
