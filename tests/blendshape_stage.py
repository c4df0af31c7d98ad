"""Small captures for tests: a performer before a coarse sensor, landmarks from the truth, everything kept."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from mien.camera import Camera
from mien.experiments.blendshapes_stage import CaptureStageConfig, capture_actor, staged_capture
from mien.landmarks.detector import COUNT, Landmarks2D, bundled_landmarks
from mien.stage import FilmConfig, HeadMotion, structured_light

SENSOR = structured_light()
CONFIG = CaptureStageConfig(
    frames=7, levels=0, rate=3.0,
    film=FilmConfig(sensor=SENSOR, head=HeadMotion(rotation=0.01, translation=2.0)),
)  # fmt: skip


@dataclass
class TrueLandmarks:
    """A landmarker that knows where the face is at each time."""

    pixels: dict[float, np.ndarray]

    def detect(self, image, time=None):
        return Landmarks2D(self.pixels[round(time, 4)], np.zeros(COUNT), {})


@cache
def capture(name: str, seed: int = 1):
    """(take, landmarker, truth) of one held expression; its frames are made once."""
    from dataclasses import replace

    staged = staged_capture(actor(seed), name, seed, CONFIG)
    frames = list(staged.take)
    take = replace(staged.take, name=name, frames=lambda: iter(frames))
    return take, TrueLandmarks(_pixels(staged.truth, take.camera, frames)), staged.truth


@cache
def actor(seed: int = 1):
    return capture_actor(seed, CONFIG)


def _pixels(truth, camera: Camera, frames) -> dict[float, np.ndarray]:
    mesh = truth.actor.mesh(truth.weights[0])
    points = bundled_landmarks().attachment.points(mesh)
    placed = truth.T_lab_face.apply(np.broadcast_to(points, (len(frames), *points.shape)))
    return {round(f.time, 4): camera.project(p) for f, p in zip(frames, placed, strict=True)}
