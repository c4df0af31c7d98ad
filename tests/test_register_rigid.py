import numpy as np
import pytest

from mien.register import procrustes, procrustes_frames, procrustes_robust
from mien.transforms import Transform, rotation_from_vector

RNG = np.random.default_rng(7)


def some_transform(angle=0.9, scale=1.0, seed=3):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return Transform(rotation_from_vector(angle * axis / np.linalg.norm(axis)), 50 * rng.normal(size=3), scale)


def test_quarter_turn_by_hand():
    source = np.array([[1.0, 0, 0], [0, 2, 0], [0, 0, 3]])
    target = np.array([[0.0, 1, 0], [-2, 0, 0], [0, 0, 3]]) + np.array([5, 6, 7])
    found = procrustes(source, target)
    np.testing.assert_allclose(found.transform.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(found.transform.translation, [5, 6, 7], atol=1e-12)
    np.testing.assert_allclose(found.residuals, 0, atol=1e-12)
    assert found.determined


@pytest.mark.parametrize("scale", [1.0, 0.01, 25.4])
def test_known_similarity_is_recovered(scale):
    source = RNG.normal(size=(20, 3))
    T = some_transform(scale=scale)
    found = procrustes(source, T.apply(source), scale=True)
    np.testing.assert_allclose(found.transform.rotation, T.rotation, atol=1e-9)
    np.testing.assert_allclose(found.transform.translation, T.translation, atol=1e-8)
    np.testing.assert_allclose(found.transform.scale, scale, rtol=1e-10)


def test_a_mirror_image_gets_a_rotation_all_the_same():
    source = RNG.normal(size=(30, 3))
    found = procrustes(source, source * [-1, 1, 1], scale=True)
    np.testing.assert_allclose(np.linalg.det(found.transform.rotation), 1, atol=1e-12)
    rest = ((found.transform.apply(source) - source * [-1, 1, 1]) ** 2).sum()
    for seed in range(20):
        R = rotation_from_vector(np.random.default_rng(seed).normal(size=3) * 2)
        other = procrustes(source @ R.T, source * [-1, 1, 1], scale=True)
        assert rest <= ((other.transform.apply(source @ R.T) - source * [-1, 1, 1]) ** 2).sum() + 1e-9


def test_planar_points_fix_the_rotation():
    source = RNG.normal(size=(9, 3)) * [1, 1, 0]
    T = some_transform()
    found = procrustes(source, T.apply(source))
    assert found.determined
    np.testing.assert_allclose(found.transform.rotation, T.rotation, atol=1e-9)


def test_points_on_a_line_get_the_smallest_rotation():
    source = np.outer(np.linspace(-1, 1, 5), [1.0, 0, 0])
    target = np.outer(np.linspace(-1, 1, 5), [np.cos(0.4), np.sin(0.4), 0]) + np.array([1, 2, 3])
    found = procrustes(source, target)
    assert not found.determined
    np.testing.assert_allclose(found.transform.rotation, rotation_from_vector(np.array([0, 0, 0.4])), atol=1e-6)
    np.testing.assert_allclose(found.residuals, 0, atol=1e-6)


def test_one_point_moves_without_turning():
    found = procrustes(np.array([[1.0, 2, 3]]), np.array([[4.0, 6, 8]]))
    assert not found.determined
    np.testing.assert_allclose(found.transform.rotation, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(found.transform.translation, [3, 4, 5])


def test_weight_two_is_a_point_twice():
    source, target = RNG.normal(size=(6, 3)), RNG.normal(size=(6, 3))
    weighted = procrustes(source, target, np.array([2.0, 1, 1, 1, 1, 1]), scale=True)
    doubled = procrustes(source[[0, 0, 1, 2, 3, 4, 5]], target[[0, 0, 1, 2, 3, 4, 5]], scale=True)
    np.testing.assert_allclose(weighted.transform.apply(source), doubled.transform.apply(source), atol=1e-10)
    np.testing.assert_allclose(weighted.rms, doubled.rms)


def test_frames_agree_with_one_by_one_and_leave_gaps_out():
    rng = np.random.default_rng(1)
    source = rng.normal(size=(12, 3))
    target = np.stack([some_transform(seed=s).apply(source) for s in range(30)]) + 0.05 * rng.normal(size=(30, 12, 3))
    target[rng.random((30, 12)) < 0.3] = np.nan
    weights = rng.random((30, 12))
    weights[:, 4] = 0
    found = procrustes_frames(source, target, weights)
    for t in range(30):
        one = procrustes(source, target[t], weights[t])
        np.testing.assert_allclose(found.transform.rotation[t], one.transform.rotation, atol=1e-10)
        np.testing.assert_allclose(found.transform.translation[t], one.transform.translation, atol=1e-9)
        np.testing.assert_array_equal(np.isnan(found.residuals[t]), np.isnan(target[t, :, 0]) | (weights[t] == 0))


def test_a_frame_with_no_point_is_undetermined():
    source = RNG.normal(size=(4, 3))
    target = np.stack([source, np.full((4, 3), np.nan)])
    found = procrustes_frames(source, target)
    np.testing.assert_array_equal(found.determined, [True, False])
    np.testing.assert_allclose(found.transform.rotation[1], np.eye(3))
    assert np.isnan(found.rms[1])


def test_bad_point_sets_are_refused():
    points = RNG.normal(size=(4, 3))
    with pytest.raises(ValueError, match="one shape"):
        procrustes(points, points[:3])
    with pytest.raises(ValueError, match="below 0"):
        procrustes(points, points, np.array([1.0, -1, 1, 1]))
    with pytest.raises(ValueError, match="no point"):
        procrustes(points, np.full((4, 3), np.nan))
    with pytest.raises(ValueError, match="source: expected"):
        procrustes_frames(points[:3], points[None])


def test_points_that_lie_far_off_lose_their_say():
    """A fifth of the points is elsewhere; the others are told where they went, also by weights of their own."""
    T, source = some_transform(), RNG.normal(0, 40, (60, 3))
    target = T.apply(source)
    target[::5] += [0, 30, 0]
    found = procrustes_robust(source, target, [8.0, 4.0, 2.0, 1.0, 0.1])
    np.testing.assert_allclose(found.transform.apply(source), T.apply(source), atol=1e-2)
    assert np.abs(procrustes(source, target).transform.apply(source) - T.apply(source)).max() > 1
    counted = np.arange(60) % 5 > 0
    told = procrustes_robust(source, target, [1e9], counted.astype(float))
    np.testing.assert_allclose(told.transform.apply(source), T.apply(source), atol=1e-9)
    with pytest.raises(ValueError, match="expected at least one"):
        procrustes_robust(source, target, [])
