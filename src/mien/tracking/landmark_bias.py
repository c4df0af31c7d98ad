"""What the landmarker always gets wrong about one face, as a function of the head's turn, learnt while tracking.

A 2D landmark has no exact place on the skin: as the head turns, and from person to person, it wanders by a millimetre
or two, the same way each time. Recursive least squares keep, for each of the 40 features, a line in yaw and pitch
through the offsets between where it was seen and where the tracked face had it. The features share one 3 x 3 system,
so that an update costs microseconds; old offsets are forgotten slowly, and before anything is learnt the correction is
zero.

Its expression scores have standing errors too: a calm face may score 0.4 at a smile. `ScoreBaseline` keeps the mean of
score less tracked coefficient.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..landmarks.on_rig import FEATURES
from ..transforms import Transform
from .model import TrackingModel
from .preprocess_frame import FrameObservation

IDS = np.array(FEATURES)

LEAST_RANGE = 0.2
"""Score above its baseline that counts as a whole expression, at least: a baseline of 0.9 leaves too little."""
LEAST_CAUTION = 1e-6
"""Frames' worth of belief in no error that keeps the first solve regular."""


@dataclass(frozen=True)
class BiasConfig:
    """Learning of the features' standing errors."""

    memory: float = 600.0
    """Frames after which an offset counts 1/e; 0 = learn nothing, correct nothing."""
    caution: float = 30.0
    """Frames' worth of belief in no error at all, to start from."""
    turn: float = 0.2
    """Radians of yaw or pitch that count like the constant part."""
    largest: float = 8.0
    """Offsets above this are not learnt from, mm."""
    calm: float = 300.0
    """Frames over which the scores' standing errors are averaged; 0 = none are taken out."""


@dataclass(frozen=True)
class Bias:
    """What has been learnt, as the sums of a least squares fit that forgets."""

    moments: Float[np.ndarray, "3 40 2"]
    """Sum of (1, pitch, yaw) times offset, mm."""
    information: Float[np.ndarray, "3 3"]
    """Sum of (1, pitch, yaw) times itself, and the belief in no error at all, which is not forgotten."""

    @property
    def coefficients(self) -> Float[np.ndarray, "3 40 2"]:
        """Constant, by pitch, by yaw; millimetres at the face."""
        return np.linalg.solve(self.information, self.moments.reshape(3, -1)).reshape(self.moments.shape)


def no_baseline(shapes: int) -> "ScoreBaseline":
    """Nothing learnt yet."""
    return ScoreBaseline(np.zeros(shapes), 0.0)


def no_bias(config: BiasConfig = BiasConfig()) -> Bias:
    """Nothing learnt yet."""
    return Bias(np.zeros((3, len(FEATURES), 2)), _caution(config))


def subtract_bias(
    observation: FrameObservation, bias: Bias, model: TrackingModel, T_camera_face: Transform, config: BiasConfig
) -> FrameObservation:
    """The observation with its 40 features moved by what they are wrong for this turn of the head."""
    if observation.rays is None or not config.memory:
        return observation
    rays = observation.rays.copy()
    z = T_camera_face.apply(model.landmark_neutral[IDS])[:, 2:]
    rays[IDS] -= np.tensordot(_turn(T_camera_face, config), bias.coefficients, axes=1) / z
    return observation.moved(rays)


def learn_bias(
    bias: Bias,
    model: TrackingModel,
    vertices: Float[np.ndarray, "f 3"],
    raw: FrameObservation,
    T_camera_face: Transform,
    config: BiasConfig,
) -> Bias:
    """Compare the features as seen (`raw`) with the tracked face, the offset common to all left out."""
    if raw.rays is None or not config.memory or not np.isfinite(raw.rays[IDS]).all(1).any():
        return bias
    points = T_camera_face.apply(model.features(vertices))
    offsets = raw.rays[IDS] * points[:, 2:] - points[:, :2]
    known = np.isfinite(offsets).all(1)
    offsets -= np.median(offsets[known], axis=0)
    turn = _turn(T_camera_face, config)
    believed = np.linalg.norm(offsets, axis=1) <= config.largest
    expected = np.tensordot(turn, bias.coefficients, axes=1)
    offsets = np.where(believed[:, None], offsets, expected)
    keep = np.exp(-1.0 / config.memory)
    information = keep * bias.information + (1 - keep) * _caution(config) + np.outer(turn, turn)
    return Bias(keep * bias.moments + turn[:, None, None] * offsets, information)


def _caution(config: BiasConfig) -> Float[np.ndarray, "3 3"]:
    return max(config.caution, LEAST_CAUTION) * np.eye(3)


def _turn(T_camera_face: Transform, config: BiasConfig) -> Float[np.ndarray, " 3"]:
    """1, pitch, yaw: from where the face's z axis points."""
    x, y, z = T_camera_face.rotation[:, 2]
    return np.array([1.0, np.arcsin(np.clip(y, -1, 1)) / config.turn, np.arctan2(x, -z) / config.turn])


@dataclass(frozen=True)
class ScoreBaseline:
    """What the landmarker scores when the face does nothing."""

    level: Float[np.ndarray, " k"]
    """Mean over the last while of score less tracked coefficient."""
    count: float
    """Frames that it was learnt from, up to the memory."""


def subtract_baseline(scores: Float[np.ndarray, " k"], baseline: ScoreBaseline) -> Float[np.ndarray, " k"]:
    """Scores as they would be had the face scored 0 at rest; NaN where there is none."""
    return np.clip((scores - baseline.level) / np.maximum(1.0 - baseline.level, LEAST_RANGE), 0.0, 1.0)


def learn_baseline(
    baseline: ScoreBaseline, scores: Float[np.ndarray, " k"], weights: Float[np.ndarray, " k"], config: BiasConfig
) -> ScoreBaseline:
    """Compare the scores with the tracked coefficients."""
    if not config.calm:
        return baseline
    gap, gain = scores - weights, max(1.0 / (baseline.count + 1), 1.0 / config.calm)
    level = baseline.level + gain * np.where(np.isfinite(gap), gap - baseline.level, 0.0)
    return ScoreBaseline(np.clip(level, 0.0, 1.0), min(baseline.count + 1, config.calm))
