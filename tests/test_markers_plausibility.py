"""What is refused as no face, and what is doubted."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.markers.left_out import LeftOutError
from mien.markers.plausibility import (
    Fit,
    PlausibilityConfig,
    doubts,
    motion_of,
    refuse_no_face,
    refuse_untold,
    why_no_face,
)

FACE = Fit(shape_mm=0.8, motion_mm=2.0, residual_mm=0.6, margin=0.5)


def test_a_face_passes_without_a_word():
    refuse_no_face(FACE)
    assert doubts(FACE) == ()


@pytest.mark.parametrize(
    ("fit", "says"),
    [
        (Fit(6.0, 2.0, 0.6, 0.5), "6.0 mm off the nearest face"),
        (Fit(3.7, 2.9, 4.1, 0.07), "3.7 mm off the nearest face"),
        (Fit(3.9, 1.0, 0.2, 0.4), "3.9 mm off the nearest face"),
        (Fit(2.0, 0.1, 0.1, 0.5), "nothing moves"),
        (Fit(0.5, 0.1, 0.1, 0.5, markers=7), "7 markers that hold still"),
        (Fit(2.0, 10.0, 12.0, 0.5), "as no expression does"),
        (Fit(2.0, 5.3, 4.9, 0.2), "as no expression does"),
        (Fit(1.9, 0.5, 0.5, 0.0, way_round_margin=0.0), "the other way round"),
        (
            Fit(1.1, 2.9, 2.5, 0.01, way_round_margin=0.01),
            "2.9 mm as no expression does, and lie on it as well",
        ),
    ],
)
def test_what_no_face_does_is_refused_and_says_why(fit, says):
    with pytest.raises(BadInput, match=says):
        refuse_no_face(fit)
    refuse_no_face(fit, PlausibilityConfig(refuse=False))


def test_a_face_that_slides_a_little_as_well_is_doubted_not_refused():
    slides = Fit(2.1, 2.8, 2.8, 0.0, markers=30, way_round_margin=0.4)
    refuse_no_face(slides)
    assert "another alignment" in doubts(slides)[0]


@pytest.mark.parametrize("fit", [Fit(3.9, 2.7, 2.5, 0.26), Fit(3.4, 4.0, 3.8, 0.37)])
def test_a_long_or_a_lively_face_is_left_to_the_markers_left_out(fit):
    refuse_no_face(fit)
    assert why_no_face(fit, PlausibilityConfig())
    refuse_untold(fit.shape_mm, told(0.37), unproven=True)
    with pytest.raises(BadInput, match="53% of their motion is missed"):
        refuse_untold(fit.shape_mm, told(0.53), unproven=True)


def test_doubts_are_lines():
    assert "--attach" in doubts(Fit(0.8, 2.0, 0.6, 0.1))[0]
    assert "2.2 mm off" in doubts(Fit(2.2, 2.0, 0.6, 0.5))[0]


def test_motion_is_about_each_markers_own_place():
    X = np.tile(np.arange(12.0).reshape(1, 4, 3), (5, 1, 1))
    assert motion_of(X) == 0
    X[:, 0, 0] += [-1, 1, 0, -1, 1]
    np.testing.assert_allclose(motion_of(X), np.sqrt(4 / 20))


def told(share: float, motion_mm: float = 2.0) -> LeftOutError:
    moved = np.full((1, 4), motion_mm)
    return LeftOutError(share * motion_mm, share, 0.0, share * moved, moved, 0.0, share)


def test_worse_than_a_face_that_does_not_move_is_refused_and_says_what_to_do():
    with pytest.raises(BadInput, match=r"105% of their motion is missed.*left and right"):
        refuse_untold(0.8, told(1.05))
    with pytest.raises(BadInput, match=r"80% of their motion is missed.* 14 mm off the nearest face"):
        refuse_untold(14.0, told(0.8))
    refuse_untold(14.0, told(1.05), PlausibilityConfig(refuse=False))


def test_a_poor_solve_of_a_face_a_still_one_and_an_untried_one_pass():
    refuse_untold(0.8, told(0.95))
    refuse_untold(14.0, told(0.4))
    refuse_untold(0.8, told(1.4, motion_mm=0.1))
    refuse_untold(0.8, LeftOutError(np.nan, np.nan))
