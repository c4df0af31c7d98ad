"""The steps that make the bundled face out of MakeHuman's data, on small inputs."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "tools"))
from face import identities, layout, rings, units, uv

TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def tube(around=8, along=4):
    """Quads of a tube: vertex number `ring * around + place`."""
    i, j = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    return np.stack([a, b, b + around, a + around], -1).reshape(-1, 4)


def test_a_ring_runs_round_the_tube():
    assert rings.QuadNet(tube()).ring(8, 9).tolist() == list(range(8, 16))


def test_an_edge_along_the_tube_has_no_ring():
    with pytest.raises(SystemExit, match="no closed edge loop"):
        rings.QuadNet(tube()).ring(0, 8)


def test_arcs_part_a_ring_at_its_ends():
    turn = np.arange(8) * np.pi / 4
    points = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    upper, lower = rings.arcs(np.arange(8), points)
    assert upper.tolist() == [4, 3, 2, 1, 0]
    assert lower.tolist() == [4, 5, 6, 7, 0]


def test_the_new_eyeball_is_a_closed_sphere_and_mirrors_itself():
    ball, quads = layout._ball()
    np.testing.assert_allclose(np.linalg.norm(ball, axis=1), 1)
    edges = np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    _, count = np.unique(edges[edges[:, 0] != edges[:, 1]], axis=0, return_counts=True)
    assert set(count.tolist()) == {2}
    flip = layout._ball_mirror(ball)
    np.testing.assert_array_equal(flip[flip], np.arange(len(ball)))


def test_an_eyeball_takes_shift_and_growth_and_nothing_else():
    points = np.random.default_rng(1).normal(size=(50, 3))
    spokes = points - points.mean(0)
    shift, growth = layout.ball_motion(points, 0.1 * spokes + [1.0, 2.0, 3.0])
    np.testing.assert_allclose(shift, [1, 2, 3])
    np.testing.assert_allclose(growth, 0.1)
    _, sheared = layout.ball_motion(points, np.stack([0 * spokes[:, 0], 0 * spokes[:, 0], spokes[:, 2]], 1))
    np.testing.assert_allclose(sheared, 0, atol=1e-12)


def test_rigid_motion_is_found_in_what_is_nearly_rigid():
    rng = np.random.default_rng(2)
    points = rng.normal(size=(40, 3))
    delta = points @ TURN.T + [1.0, 0.0, 2.0] - points
    np.testing.assert_allclose(units.rigid_motion(points, delta), delta, atol=1e-12)
    near = units.rigid_motion(points, delta + 0.01 * rng.normal(size=delta.shape))
    np.testing.assert_allclose(near, delta, atol=0.02)


def test_alignment_takes_rigid_motion_out():
    points = np.random.default_rng(3).normal(size=(30, 3))
    back = identities.align(points @ TURN.T + [4.0, -1.0, 0.5], points, np.linspace(0.1, 1, 30))
    np.testing.assert_allclose(back, points, atol=1e-12)


def test_names_of_targets_are_taken_apart():
    assert identities._split("l-eye-bag-incr") == ("l", "eye-bag:incr/decr", "0")
    assert identities._split("r-eye-bag-in") == ("r", "eye-bag:out/in", "1")
    assert identities._split("asym-jaw-1-r") == ("", "asym-jaw-1:l/r", "1")
    assert identities._split("head-oval") == ("", "head-oval", "0")


def families():
    field = np.ones((2, 3))
    names = [f"nose-{k}:incr/decr" for k in range(20)] + [f"nose-scale-{k}:incr/decr" for k in range(10)]
    return [identities.Family(name, {"": (field, -field)}) for name in names]


def test_a_third_of_the_families_is_held_out_and_no_plain_size():
    kept, held = identities.split_held_out(families())
    assert len(held) == 10
    assert len(kept) == 20
    assert not any("-scale" in family.name for family in held)
    again = identities.split_held_out(families()[::-1])[1]
    assert {f.name for f in again} == {f.name for f in held}


def test_identity_modes_have_the_people_as_their_spread():
    rng = np.random.default_rng(4)
    mean = rng.normal(size=(20, 3)) * 50
    mean[:, 0] = np.abs(mean[:, 0])
    mean = np.concatenate([mean, mean * [-1, 1, 1]])
    mirror = np.r_[20:40, 0:20]
    bump = rng.normal(size=(40, 3))
    bump = bump + bump[mirror] * [-1, 1, 1]
    people = np.stack([mean + a * bump for a in rng.normal(0, 2, 60)])
    people = np.concatenate([people, people[:, mirror] * [-1, 1, 1]])
    size = identities.SIZE
    identities.SIZE = 0.0
    try:
        modes, explained = identities.identity_space(people, np.ones(40))
    finally:
        identities.SIZE = size
    spread = (people - people.mean(0)).std(0)
    assert len(modes) == 1
    assert explained > 0.999
    np.testing.assert_allclose(np.abs(modes[0]), spread, atol=1e-9)


def test_charts_are_packed_apart_in_the_unit_square():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    charts = np.concatenate([square * [0.4, 0.6], [[0.2, 0.3]], 0.1 * square + 0.7, 0.1 * square + 0.85])
    corners = np.array([[0, 1, 4, 4], [1, 2, 4, 4], [2, 3, 4, 4], [5, 6, 7, 8], [9, 10, 11, 12]])
    packed = uv.pack(charts * 0.6, corners, np.array([0, 0, 0, 0, 0]))
    assert packed.min() >= 0
    assert packed.max() <= 1
    boxes = [(packed[c].min(0), packed[c].max(0)) for c in (slice(0, 5), slice(5, 9), slice(9, 13))]
    for i, (low, high) in enumerate(boxes):
        for other_low, other_high in boxes[i + 1 :]:
            assert (high < other_low).any() or (other_high < low).any()
