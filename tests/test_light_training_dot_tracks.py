import numpy as np
import pytest

import light_dots
from mien.errors import BadInput
from mien.light.training.dot_tracks import follow_dots, moved_head, mutual_nearest, neighbours_steps
from mien.mesh import Mesh, grid_faces


def test_dots_keep_their_labels_under_a_motion_of_half_their_distance():
    before = light_dots.places()
    after = light_dots.places(light_dots.pose((0.02, 0.03, 0.02), (2.0, 1.0, 0.0)))
    shuffled = np.random.default_rng(0).permutation(len(after))
    found = follow_dots(before, after[shuffled])
    assert found.seen.all()
    np.testing.assert_allclose(found.positions, after)


def test_dots_that_go_farther_than_half_their_distance_are_found_where_they_would_go_on_to():
    before = light_dots.places()
    apart = np.sort(np.linalg.norm(before - before[0], axis=1))[1]
    step = np.tile([0.7 * apart, 0.2 * apart, 0.0], (len(before), 1))
    after = before + step + 0.2 * np.random.default_rng(0).normal(size=before.shape)
    found = follow_dots(before, after, step=step)
    assert found.seen.all()
    np.testing.assert_allclose(found.positions, after)
    stopped = follow_dots(before, before[::-1], step=step)
    np.testing.assert_allclose(stopped.positions, before)


def test_a_lost_dot_goes_with_its_neighbours_and_a_mole_is_no_dot():
    before = light_dots.places()
    after = before + np.array([2.0, 0.0, 0.0])
    mole = after[:1] + np.array([0.0, 9.0, 0.0])
    found = follow_dots(before, np.concatenate([after[1:], mole]))
    assert not found.seen[0]
    assert found.seen[1:].all()
    np.testing.assert_allclose(found.positions, after)


def test_another_face_is_told():
    with pytest.raises(BadInput, match="same face and dots"):
        follow_dots(light_dots.places(), light_dots.places() + 300.0)
    with pytest.raises(BadInput, match="0 of 24"):
        follow_dots(light_dots.places(), np.zeros((0, 3)))


def test_nearest_ones_are_mutual_and_within_reach():
    one, other = mutual_nearest(np.array([[0.0, 0, 0], [1, 0, 0], [9, 0, 0]]), np.array([[0.9, 0, 0], [20, 0, 0]]), 5.0)
    assert one.tolist() == [1]
    assert other.tolist() == [0]


def test_one_wrong_match_among_the_neighbours_does_not_count():
    before = light_dots.places()
    steps = np.tile([1.0, 0.0, 0.0], (len(before), 1))
    steps[3] = [-5.0, 4.0, 0.0]
    np.testing.assert_allclose(neighbours_steps(before, np.arange(len(before)), steps), [[1.0, 0, 0]] * len(before))


def test_a_head_that_moved_between_clips_is_met_by_its_surface():
    scan = light_dots.scan(ripple=2.0)
    known = scan.known
    number = np.cumsum(known) - 1
    skin = Mesh(scan.points[known], number.reshape(known.shape).ravel()[grid_faces(scan.points, 6.0)])
    T = light_dots.pose((0.01, 0.02, 0.0), (3.0, -2.0, 1.0))
    moved = moved_head(light_dots.places(), skin, light_dots.scan(T, ripple=2.0), step=2)
    assert np.linalg.norm(moved - light_dots.places(T), axis=1).max() < 2.0
