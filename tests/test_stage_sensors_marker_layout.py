"""Where markers are glued."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.stage import make_performer, marker_layout


@pytest.fixture(scope="module")
def actor():
    return make_performer(2)


def places(actor, count, seed=0):
    return marker_layout(actor, count, seed).attachment.points(actor.neutral)


@pytest.mark.parametrize("count", [6, 30, 100])
def test_as_many_as_asked_for_named_from_the_forehead_down(actor, count):
    layout = marker_layout(actor, count)
    assert layout.labels == tuple(f"M{i:03d}" for i in range(count))
    heights = layout.attachment.points(actor.neutral)[:, 1]
    assert (np.diff(heights) < 3).all()


def test_they_are_well_spread_and_in_pairs(actor):
    points = places(actor, 60)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + 1e3 * np.eye(60)
    assert apart.min() > 3
    other = points * [-1, 1, 1]
    assert np.quantile(np.linalg.norm(points[:, None] - other[None], axis=2).min(axis=1), 0.9) < 6


def test_the_seed_decides(actor):
    np.testing.assert_array_equal(places(actor, 30, 1), places(actor, 30, 1))
    assert np.abs(places(actor, 30, 1) - places(actor, 30, 2)).max() > 1


@pytest.mark.parametrize("count", [5, 401])
def test_counts_that_nobody_glues_are_refused(actor, count):
    with pytest.raises(BadInput, match="6 to 400"):
        marker_layout(actor, count)
