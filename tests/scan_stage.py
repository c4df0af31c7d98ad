"""A take of rest, open jaw and smile on the stage, and coarse scans of the three."""

from functools import cache

import numpy as np

from mien.fitting.register_scan import RegisterConfig
from mien.landmarks.lift import LiftConfig
from mien.scans.correspond.fine_scale import FineConfig
from mien.scans.pipeline import ScansConfig
from mien.stage import MocapConfig, ScanConfig, make_performer, marker_layout, perform, scan

FRAMES = (10, 70, 110)
QUICK = ScansConfig(
    density=0,
    fit=RegisterConfig(lift=LiftConfig(sweep_pixels=256, pixels=480, views=((0.0, 0.0), (-0.25, 0.0), (0.25, 0.0)))),
    fine=FineConfig(sweeps=1, pixel_mm=1.5, curvature_radius_mm=6.0),
)
"""Few and small pictures, a coarse template and layout."""


@cache
def scan_stage():
    """A take of rest, open jaw, smile, and coarse scans of the three."""
    actor = make_performer(5)
    weights = np.zeros((140, len(actor.names)))
    swell = np.sin(np.linspace(0, np.pi, 40)) ** 0.5
    weights[50:90, actor.names.index("jawOpen")] = 0.6 * swell
    for side in ("Left", "Right"):
        weights[90:130, actor.names.index(f"mouthSmile{side}")] = 0.8 * swell
    layout = marker_layout(actor, 60)
    take = perform(actor, weights, 60.0, layout, MocapConfig(jitter=0.05, dropouts=0.01), seed=5)
    config = ScanConfig(vertices=12_000, performance_sigma=0.2, colour=False)
    scans = [scan(actor, weights[f], config, seed=20 + i, name=f"s_{f:03d}") for i, f in enumerate(FRAMES)]
    return actor, take, layout, scans
