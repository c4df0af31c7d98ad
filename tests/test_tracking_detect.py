"""Where the head is, from landmarks alone."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.tracking.detect import WrongScale, check_size, detect, length


@pytest.fixture(scope="module")
def seen():
    rig, T = stage.person(), stage.pose((0.1, 0.3, -0.1), (20, -10, 30))
    still = np.zeros(52)
    return stage.sensed(rig, still, T, noise=0.5), stage.told(rig, still, T, noise=0.3), T


def off(found, true):
    points = stage.model().neutral[::50].astype(float)
    return np.linalg.norm(found.apply(points) - true.apply(points), axis=1).mean()


def test_a_neutral_head_is_found_with_and_without_depth(seen):
    frame, marks, T = seen
    assert off(detect(stage.model(), frame, marks, stage.CAMERA), T) < 1.5
    blind = replace(frame, depth=None)
    assert off(detect(stage.model(), blind, marks, stage.CAMERA), T) < 15


def test_landmarks_that_are_no_numbers_are_left_out(seen):
    frame, marks, T = seen
    points = marks.points.copy()
    points[::3] = np.nan
    assert off(detect(stage.model(), frame, replace(marks, points=points), stage.CAMERA), T) < 2.0


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_a_face_of_another_size_is_told_with_the_scale_that_would_mend_it(factor):
    model = stage.model()
    points = np.full((478, 3), np.nan)
    points[[33, 263]] = [[0.0, 0, 500], [factor * model.scale_mm, 0, 500]]
    with pytest.raises(WrongScale, match=f"multiply depth_scale .* by {factor:g} ") as told:
        check_size(model, points)
    assert told.value.factor == pytest.approx(factor)
    check_size(model, np.full((478, 3), np.nan))


def test_lengths_in_words():
    assert [length(mm) for mm in (1500.0, 150.0, 1.5)] == ["1.50 m", "150 mm", "1.5 mm"]
