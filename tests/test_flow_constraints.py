"""Points and curves that hold the flow."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.flow import FlowConfig, FlowConstraints, curve_constraints, optical_flow
from mien.flow.warp import splat


def _points(*rows):
    return np.array(rows, float)


def test_points_are_held_in_all_directions():
    held = FlowConstraints(_points((1, 2), (3, 4)), _points((2, 2), (3, 5)))
    np.testing.assert_array_equal(held.stiffness, [np.eye(2), np.eye(2)])


def test_a_curve_is_paired_by_arc_length():
    source, target = _points((0, 0), (10, 0)), _points((0, 5), (0, 25))
    pairs = curve_constraints(source, target, spacing=2.5)
    np.testing.assert_allclose(pairs.source, [[0, 0], [2.5, 0], [5, 0], [7.5, 0], [10, 0]], atol=1e-12)
    np.testing.assert_allclose(pairs.target, [[0, 5], [0, 10], [0, 15], [0, 20], [0, 25]], atol=1e-12)


def test_a_curve_is_slack_along_itself_and_firm_across():
    pairs = curve_constraints(_points((0, 0), (10, 0)), _points((0, 3), (6, 11)), spacing=1.0)
    along, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    for form in pairs.stiffness[1:-1]:
        np.testing.assert_allclose(across @ form @ across, 1)
        assert along @ form @ along < 0.1
        np.testing.assert_allclose(along @ form @ across, 0, atol=1e-12)
    np.testing.assert_allclose(pairs.stiffness[[0, -1]], [np.eye(2), np.eye(2)])


def test_sum_and_move_of_constraints():
    points = FlowConstraints(_points((5, 6)), _points((7, 8)))
    both = points + curve_constraints(_points((0, 0), (4, 0)), _points((0, 1), (4, 1)), spacing=2.0)
    assert len(both.source) == 4
    np.testing.assert_array_equal(both.stiffness[0], np.eye(2))
    moved = both.moved((5, 1))
    np.testing.assert_array_equal(moved.source[0], [0, 5])
    np.testing.assert_array_equal(moved.target - moved.source, both.target - both.source)


def test_splat_keeps_sum_and_centre():
    places, values = _points((2.3, 4.6), (0, 0), (7, 5)), _points((2, 1), (3, -1), (4, 0))
    image = splat(places, values, (6, 8))
    np.testing.assert_allclose(image.sum((0, 1)), values.sum(0), atol=1e-12)
    assert image[0, 0, 0] == 3
    assert image[5, 7, 0] == 4
    single = splat(places[:1], values[:1, :1], (6, 8))[..., 0]
    y, x = np.mgrid[:6, :8]
    np.testing.assert_allclose([(x * single).sum() / 2, (y * single).sum() / 2], places[0])


def test_start_says_what_the_constraint_says_nearby_and_nothing_far_off():
    held = FlowConstraints(_points((20, 20)), _points((23, 18)))
    start = held.start(np.ones((40, 60, 2), np.float32), (1.0, 1.0), reach=6.0)
    np.testing.assert_allclose(start[20, 20], [3, -2], atol=1e-5)
    np.testing.assert_allclose(start[17, 22], [3, -2], atol=1e-5)
    np.testing.assert_allclose(start[20, 50], [1, 1], atol=1e-5)


def test_a_curve_pulls_a_crease_into_place():
    """Two creases too far apart for the flow; a curve drawn roughly along them brings one onto the other."""
    y, x = np.mgrid[:80, :80].astype(float)
    source = np.exp(-((y - 25 - 0.1 * x) ** 2) / 4)
    target = np.exp(-((y - 50 - 0.1 * x) ** 2) / 4)
    line = np.array([[10.0, 26.0], [70.0, 32.0]])
    held = curve_constraints(line, line + np.array([0.0, 25.0]), spacing=4.0)
    flow = optical_flow(source, target, constraints=held, config=FlowConfig(margin=80)).flow
    on = np.abs(y - 25 - 0.1 * x) < 2
    on[:, :12], on[:, -12:] = False, False
    assert np.abs((flow[..., 1] - 0.1 * flow[..., 0])[on] - 25).mean() < 0.2


def test_bad_constraints_are_named():
    with pytest.raises(BadInput, match="2 source points but 1"):
        FlowConstraints(np.zeros((2, 2)), np.zeros((1, 2)))
    with pytest.raises(BadInput, match="not finite"):
        FlowConstraints(np.zeros((1, 2)), np.full((1, 2), np.nan))
    with pytest.raises(BadInput, match="target curve has 1 points"):
        curve_constraints(np.array([[0.0, 0], [1, 1]]), np.zeros((1, 2)))
    with pytest.raises(BadInput, match="no length"):
        curve_constraints(np.array([[0.0, 0], [1, 1]]), np.zeros((3, 2)))
