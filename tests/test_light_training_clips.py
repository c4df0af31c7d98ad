from dataclasses import replace

import numpy as np
import pytest

import light_dots
from mien.errors import BadInput
from mien.light.training.clips import (
    LostFrame,
    TrainingConfig,
    TrainingFrame,
    common_neutral,
    registered_clip,
    shown_positions,
)
from mien.light.training.common_surface import CommonConfig
from mien.light.training.dots import DotConfig

CONFIG = TrainingConfig(
    dots=DotConfig(radius_mm=light_dots.RADIUS_MM), common=CommonConfig(grid_mm=1.6, relief_mm=4.0, refine=False)
)


@pytest.fixture(scope="module")
def neutral():
    return common_neutral(light_dots.scan(ripple=0.4), CONFIG)


def test_a_clip_is_followed_frame_by_frame_and_a_bad_capture_is_named(neutral):
    turned = light_dots.pose((0.0, 0.06, 0.0))
    scans = [light_dots.scan(ripple=0.4), BadInput("dark"), light_dots.scan(turned, ripple=0.4)]
    first, lost, last = registered_clip(neutral, scans, light_dots.VIEW, CONFIG)
    assert isinstance(lost, LostFrame)
    assert (lost.number, lost.why) == (1, "dark")
    assert isinstance(first, TrainingFrame)
    assert isinstance(last, TrainingFrame)
    assert last.dots.seen.mean() > 0.9
    inside = last.skin.seen & (np.linalg.norm(neutral.mesh.vertices[:, :2], axis=1) < 50)
    off = np.linalg.norm(last.skin.vertices - turned.apply(neutral.mesh.vertices), axis=1)
    assert np.median(off[inside]) < 0.2


def test_lost_dots_are_gaps(neutral):
    (frame,) = registered_clip(neutral, [light_dots.scan(ripple=0.4)], light_dots.VIEW, CONFIG)
    seen = frame.dots.seen.copy()
    seen[2] = False
    positions = shown_positions(replace(frame.dots, seen=seen))
    assert np.isnan(positions[2]).all()
    assert np.isfinite(positions[seen]).all()
