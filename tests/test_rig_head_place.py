"""Heads that do not stand at the origin."""

import numpy as np
import pytest

from mien.faces import load_face
from mien.rig import Rig
from mien.rig.head_place import HeadPlace, find_head, place_motion
from mien.transforms import Transform, rotation_from_vector


def standing(height: float = 1600.0, scale: float = 1.0, backward: bool = False) -> Rig:
    rig = load_face().rig
    turn = np.diag([-1.0, 1.0, -1.0]) if backward else np.eye(3)
    neutral = rig.neutral.with_vertices(scale * rig.neutral.vertices @ turn.T + [0, height, 0])
    return Rig(neutral, scale * rig.deltas @ turn.T, rig.names)


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_the_head_is_found_where_it_stands(scale, backward):
    found = find_head(standing(scale=scale, backward=backward))
    assert np.linalg.norm(found.centre - [0, 1600, 0]) < 20
    assert found.R_rig_face[2, 2] == (-1 if backward else 1)
    assert not found.in_face_space


@pytest.mark.parametrize(
    ("left", "up"),
    [([0, 0, -1], [0, 1, 0]), ([0, 0, 1], [0, 1, 0]), ([1, 0, 0], [0, 0, 1]), ([-1, 0, 0], [0, 0, 1]),
     ([0, 1, 0], [0, 0, 1]), ([0, -1, 0], [0, 0, 1])],
)  # fmt: skip
@pytest.mark.parametrize("swapped", [False, True])
def test_a_head_that_looks_aside_or_lies_is_known_by_its_axes(left, up, swapped):
    """Whichever way the scene has it up, and whoever's left the shapes' names mean."""
    turn = np.stack([left, up, np.cross(left, up)], axis=1).astype(float)
    rig = load_face().rig
    names = [
        name.translate(str.maketrans("LR", "RL")).replace("Reft", "Right").replace("Light", "Left")
        for name in rig.names
    ]
    neutral = rig.neutral.with_vertices(rig.neutral.vertices @ turn.T + [300, 400, 1600])
    found = find_head(Rig(neutral, rig.deltas @ turn.T, tuple(names) if swapped else rig.names))
    np.testing.assert_array_equal(found.R_rig_face, turn)
    assert np.linalg.norm(found.centre - [300, 400, 1600]) < 20


def test_a_head_in_another_unit_travels_in_its_own_size():
    tiny = find_head(standing(height=80.0, scale=0.05))
    assert not tiny.in_face_space
    assert 0.04 < tiny.scale < 0.06
    motion, notes = place_motion(
        Transform(np.eye(3)[None].repeat(3, 0), np.array([[0.0, 0, -9], [0, 0, 0], [0, 0, 9]])), tiny
    )
    np.testing.assert_allclose(np.ptp(motion.translation[:, 2]), 18 * tiny.scale)
    assert "times a person's size" in notes[0]


def test_a_rig_in_face_space_takes_poses_as_they_are():
    pose = Transform(rotation_from_vector(np.array([[0.0, 0.3, 0.0]])), np.array([[0.0, 0.0, -600.0]]))
    head = find_head(load_face().rig)
    assert head.in_face_space
    assert place_motion(pose, head) == (pose, [])


def test_without_lids_what_moves_tells():
    rig = standing()
    few = Rig(rig.neutral, rig.deltas[[rig.index("jawOpen")]], ("A",))
    assert np.linalg.norm(find_head(few).centre - [0, 1600, 0]) < 120


def test_the_head_turns_about_its_own_centre():
    head = HeadPlace(np.array([0.0, 1600.0, 30.0]), np.eye(3))
    pose = Transform(rotation_from_vector(np.array([[0.0, 0, 0], [0.4, 0, 0]])), np.array([[0.0, 0, 0], [0, 5, 0]]))
    motion, notes = place_motion(pose, head)
    np.testing.assert_allclose(
        motion.apply(np.tile(head.centre, (2, 1, 1)))[:, 0], [[0, 1600, 30], [0, 1605, 30]], atol=1e-9
    )
    np.testing.assert_array_equal(motion.rotation, pose.rotation)
    assert notes == ["the head turns about its own centre, (0.00, 1.60, 0.03) m"]


def test_a_head_that_looks_backward_nods_its_own_way():
    """A nod takes the nose down, whichever way it looks."""
    head = HeadPlace(np.array([0.0, 1600.0, 0.0]), np.diag([-1.0, 1.0, -1.0]))
    nod = Transform(rotation_from_vector(np.array([[0.4, 0.0, 0.0]])), np.zeros((1, 3)))
    nose = place_motion(nod, head)[0].apply(np.array([[[0.0, 1600.0, -100.0]]]))[0, 0]
    np.testing.assert_allclose(nose, [0, 1600 - 100 * np.sin(0.4), -100 * np.cos(0.4)], atol=1e-9)


def test_where_the_take_was_and_faced_is_left_out_for_an_avatar():
    about = rotation_from_vector(np.array([0.0, np.pi / 2, 0.0]))
    turns = rotation_from_vector(np.array([[0.0, -0.2, 0.0], [0.0, 0.2, 0.0]]))
    pose = Transform(about @ turns, np.array([[2000.0, 100, 0], [2010.0, 100, 0]]))
    head = HeadPlace(np.array([0.0, 1600.0, 0.0]), np.eye(3))
    motion, notes = place_motion(pose, head)
    np.testing.assert_allclose(motion.rotation, turns, atol=1e-9)
    np.testing.assert_allclose(motion.apply(np.tile(head.centre, (2, 1, 1)))[:, 0, 2], [-5, 5], atol=1e-6)
    assert len(notes) == 3
