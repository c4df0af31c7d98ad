"""A plain stage for the tracker's tests: somebody of the identity space, a pinhole depth sensor, landmarks told.

The tracker proper is tested against the performer and MediaPipe elsewhere; here everything is known to the digit.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.faces.bundled import load_face
from mien.landmarks.detector import COUNT, Landmarks2D
from mien.landmarks.on_rig import LandmarkMap, bundled_map
from mien.pictures.raycast import depth_image
from mien.rgbd import RgbdTake
from mien.rig import Rig
from mien.tracking.model import TrackingModel, tracking_model
from mien.tracking.preprocess_frame import PreprocessFrameConfig, preprocess_frame
from mien.tracking.rigid import LEVER, moved
from mien.transforms import Transform, rotation_from_vector

CAMERA = Camera(262.5, 262.5, 159.5, 119.5, 320, 240)
FRONT = np.diag([1.0, -1.0, -1.0])


@cache
def person(seed: int = 1) -> Rig:
    """A rig of somebody in the identity space."""
    face = load_face()
    return face.person(np.random.default_rng(seed).normal(0, 0.7, 12))


@cache
def model(seed: int = 1) -> TrackingModel:
    return tracking_model(person(seed), landmarks())


def landmarks() -> LandmarkMap:
    return bundled_map()


def pose(turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0), distance=600.0) -> Transform:
    """A head before the camera, turned by a rotation vector (radians, face space) and shifted (mm)."""
    return Transform(FRONT @ rotation_from_vector(np.array(turn)), np.array([0.0, 0.0, distance]) + shift)


def named(rig: Rig, **values: float) -> np.ndarray:
    weights = np.zeros(len(rig.names))
    for name, value in values.items():
        weights[rig.index(name)] = value
    return weights


def sensed(rig: Rig, weights, T: Transform, time=0.0, noise=0.0, seed=0) -> RGBDFrame:
    """Depth of the rig, exact or with white noise (mm)."""
    z = depth_image(rig.mesh(weights), CAMERA, T).depth
    z = z + np.random.default_rng(seed).normal(0, noise, z.shape) if noise else z
    color = np.full((*z.shape, 3), 120, np.uint8)
    return RGBDFrame(color, np.nan_to_num(z).astype(np.float32), time)


def told(rig: Rig, weights, T: Transform, noise=0.0, seed=0) -> Landmarks2D:
    """Landmarks where they are, or with white noise (pixels)."""
    points = T.apply(landmarks().attachment.points(rig.mesh(weights)))
    pixels = CAMERA.project(points) + np.random.default_rng(seed).normal(0, 1, (COUNT, 2)) * noise
    rough = (points[:, 2] - points[:, 2].mean()) * CAMERA.fx / points[:, 2].mean()
    return Landmarks2D(pixels, rough, dict(zip(rig.names, np.asarray(weights, float).tolist(), strict=True)))


@dataclass(frozen=True)
class Told:
    """A landmarker that knows the answers by the clock."""

    answers: dict[float, Landmarks2D | None]

    def detect(self, image, time=None):
        return self.answers[round(time, 4)]


def acted(rig: Rig, weights: np.ndarray, poses: list[Transform], rate=30.0, noise=0.0) -> tuple[RgbdTake, Told]:
    """A take and its landmarker."""
    frames = [sensed(rig, w, T, t / rate, noise, t) for t, (w, T) in enumerate(zip(weights, poses, strict=True))]
    answers = {round(f.time, 4): told(rig, w, T) for f, w, T in zip(frames, weights, poses, strict=True)}
    return RgbdTake("acted", CAMERA, rate, len(frames), True, lambda: iter(frames)), Told(answers)


def talk(rig: Rig, frames: int) -> np.ndarray:
    """Jaw and smile that come and go, after three calm frames."""
    t = np.maximum(np.arange(frames) - 3, 0) / 12
    weights = np.zeros((frames, len(rig.names)))
    weights[:, rig.index("jawOpen")] = 0.4 * np.sin(t) ** 2
    weights[:, rig.index("mouthSmileLeft")] = weights[:, rig.index("mouthSmileRight")] = 0.6 * np.sin(0.7 * t) ** 2
    return weights


def sway(frames: int) -> list[Transform]:
    t = np.arange(frames) / 20
    return [pose((0.1 * np.sin(a), 0.2 * np.sin(0.8 * a), 0.0), (8 * np.sin(a), 0, 10 * np.sin(0.5 * a))) for a in t]


CALM = 6


@cache
def calm(noise: float = 0.8):
    """Six frames of a calm face that turns: the take, its landmarker, the poses."""
    rig = person(5)
    poses = [pose((0.02 * t, 0.05 * t - 0.1, 0), (t, 0, 0), 500.0) for t in range(CALM)]
    return (*acted(rig, np.zeros((CALM, 52)), poses, noise=noise), poses)


def moment():
    """The model, a turned head's pose, its weights, and what the tracker is given of it."""
    rig, m = person(), model()
    T = pose((0.1, 0.15, 0.05), (3, 2, 1))
    truth = named(rig, jawOpen=0.35, mouthSmileLeft=0.6, browInnerUp=0.5)
    frame, marks = sensed(rig, truth, T), told(rig, truth, T)
    return m, T, truth, preprocess_frame(frame, CAMERA, None, marks, PreprocessFrameConfig(radius=0))


def turned(T: Transform, z: np.ndarray, centre: np.ndarray) -> Transform:
    """The pose after a step of the fit, whose last six unknowns are the head's."""
    motion = z[-6:].copy()
    motion[:3] /= LEVER
    return moved(T, motion, centre)
