"""A take under a headset whose weights are told: the true upper shapes, and a mouth at rest."""

from dataclasses import replace

import numpy as np

from mien.depth import RGBDFrame
from mien.experiments.hidden_face import HiddenFace
from mien.faces.arkit import ARKIT_NAMES
from mien.rig import Performance, Rig
from mien.stage import Truth, make_performer
from mien.tracking.hidden.gauge_regression import GaugeRegression
from mien.transforms import Transform

UPPER = np.array([name.startswith(("brow", "eyeB", "eyeS", "eyeW", "cheekSquint")) for name in ARKIT_NAMES])
CALM = 2
"""Frames at rest at the beginning."""


def under_headset(rig: Rig, frames: int = 8) -> HiddenFace:
    """Random weights after some calm, played by a rig that has the ARKit shapes; the pictures are black."""
    true = np.random.default_rng(0).uniform(0, 1, (frames, 52))
    true[:CALM] = 0
    told = np.zeros((frames, len(rig.names)))
    for column, name in enumerate(ARKIT_NAMES):
        told[:, rig.index(name)] = true[:, column] * UPPER[column]
    driven = Performance(rig, told, Transform.identity(frames), 15.0, np.ones(frames, bool))
    calm = replace(driven, weights=np.zeros_like(told))
    truth = Truth(make_performer(1), true, Transform.identity(frames), 15.0)
    black = [RGBDFrame(np.zeros((48, 64, 3), np.uint8), None, i / 15.0) for i in range(frames)]
    nothing = GaugeRegression(("a",), ("browDownLeft",), np.ones(1), np.zeros((1, 1)), np.zeros(1), np.zeros(1), ())
    return HiddenFace(black, truth, driven, driven, calm, nothing)
