"""Correspondences by hand, as the flow of one scan takes them."""

from dataclasses import dataclass

import numpy as np

from mien.flow import FlowConstraints
from mien.image_space.constraints import PairConstraint
from mien.image_space.flow_constraints import HOLD_MM, constraints_in_region, constraints_on, falloff_round


@dataclass(frozen=True)
class Flat:
    """A scan that lies in the image as it stands, its vertices `shift` to the right."""

    shift: float

    def pixels(self, points):
        return points[:, :2]

    def transported(self, points, uv):
        return points[:, :2] + uv[0]

    @property
    def uv(self):
        return np.full((1, 2), [self.shift, 0.0])


def test_a_point_has_all_the_say_where_it_is_and_less_around():
    found = falloff_round(np.array([[5.0, 8.0], [900.0, 3.0]]), (20, 30), 2.0)
    assert found[8, 5] == 1
    np.testing.assert_allclose(found[8, 7], np.exp(-0.5))
    assert found[3, 29] == 1


def test_a_region_keeps_what_starts_in_it():
    mask = np.zeros((10, 20))
    mask[:, :10] = 1
    held = FlowConstraints(np.array([[4.0, 5.0], [15.0, 5.0]]), np.array([[5.0, 5.0], [16.0, 5.0]]))
    inside = constraints_in_region(held, mask)
    assert inside is not None
    np.testing.assert_array_equal(inside.source, [[4.0, 5.0]])
    assert constraints_in_region(held, np.zeros((10, 20))) is None
    assert constraints_in_region(None, mask) is None


def test_both_scans_of_a_pair_learn_where_they_belong():
    scans = [Flat(0.0), Flat(3.0)]
    pair = PairConstraint((0, 1), np.array([[[10.0, 10.0, 0.0]], [[12.0, 11.0, 0.0]]]))
    first, second = (constraints_on(scans, i, [pair], 1.0) for i in (0, 1))
    assert first is not None
    assert second is not None
    step = first.target - first.source
    np.testing.assert_allclose(step, np.broadcast_to([-2.0, -1.0], step.shape))
    step = second.target - second.source
    np.testing.assert_allclose(step, np.broadcast_to([12.0 - 13.0, 1.0], step.shape))
    assert np.linalg.norm(first.source - [12.0, 11.0], axis=1).max() <= HOLD_MM
    assert constraints_on([*scans, Flat(0.0)], 2, [pair], 1.0) is None


def test_a_curve_holds_along_its_whole_length():
    line = np.array([[0.0, 0, 0], [20, 0, 0]])
    pair = PairConstraint((0, 1), np.zeros((2, 0, 3)), ((line, line + np.array([0.0, 4, 0])),))
    found = constraints_on([Flat(0.0), Flat(0.0)], 0, [pair], 1.0)
    assert found is not None
    assert np.ptp(found.source[:, 0]) > 18
    np.testing.assert_allclose((found.target - found.source)[:, 1], -4.0, atol=1e-6)
