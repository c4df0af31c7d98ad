"""A face with sixty places on it, and a small linear model of markers: what the tests of marker takes share."""

from functools import cache

import numpy as np

from mien.faces import load_face
from mien.mesh import Attachment
from mien.stage import make_performer, marker_layout, perform, scripted
from mien.takes.frame_solve import SolveConfig
from mien.takes.marker_model import MarkerModel
from mien.transforms import Transform, rotation_from_vector

FREE = SolveConfig(sparsity=0.0, smoothness=0.0, ridge=1e-9, rounds=6, outlier=np.inf, still_power=0.0)


def motion(frames: int, seed: int, angle: float = 0.2, distance: float = 40.0) -> Transform:
    """A smooth head motion."""
    rng = np.random.default_rng(seed)
    phase, time = rng.uniform(0, 6, size=6), np.linspace(0, 5, frames)[:, None]
    waves = np.sin(time * rng.uniform(0.5, 1.5, size=6) + phase)
    return Transform(rotation_from_vector(angle * waves[:, :3]), distance * waves[:, 3:])


@cache
def region() -> np.ndarray:
    """Triangles of the face."""
    face = load_face()
    return np.flatnonzero((face.regions["face"] > 0.5)[face.rig.neutral.faces].all(axis=1))


@cache
def held() -> Attachment:
    """Sixty well-spread places on the face."""
    face = load_face()
    centres = face.rig.neutral.vertices[face.rig.neutral.faces[region()]].mean(axis=1)
    chosen, distance = [0], np.full(len(region()), np.inf)
    while len(chosen) < 60:
        distance = np.minimum(distance, np.linalg.norm(centres - centres[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return Attachment(region()[chosen], np.full((60, 3), 1 / 3))


@cache
def small_model() -> MarkerModel:
    """Forty markers moved by six shapes at random."""
    rng = np.random.default_rng(9)
    return MarkerModel(rng.normal(size=(40, 3)) * 40, rng.normal(size=(6, 40, 3)) * 4)


@cache
def acted() -> tuple[np.ndarray, Transform, np.ndarray]:
    """Weights, head motion and the clean markers they make with `small_model`."""
    rng = np.random.default_rng(10)
    W = np.clip(rng.normal(0.1, 0.4, size=(50, 6)), 0, 1)
    T = motion(50, 11)
    return W, T, T.apply(small_model().points(W))


@cache
def staged_take():
    """Ten seconds of a performer with sixty markers."""
    performer = make_performer(3)
    return perform(performer, scripted(24.0, 10.0).weights, 24.0, marker_layout(performer, 60), seed=3)
