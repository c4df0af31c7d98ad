"""ARKit's names and what the shapes of these names do."""

import numpy as np
import pytest

from mien.faces import ARKIT_NAMES, load_face
from mien.faces.arkit import opposite
from whole_face import FLIP, chin, delta, shape


@pytest.fixture(scope="module")
def face():
    return load_face()


def lip_gap(vertices, face):
    """Height between the lips where they are farthest apart."""
    upper, lower = (vertices[face.contours[name]] for name in ("upper_lip", "lower_lip"))
    inner = upper[2:-2]
    order = np.argsort(lower[:, 0])
    return (inner[:, 1] - np.interp(inner[:, 0], lower[order, 0], lower[order, 1])).max()


@pytest.mark.parametrize("name", ARKIT_NAMES)
def test_each_shape_is_the_mirror_image_of_its_opposite(face, name):
    there = delta(face, opposite(name))[face.mirror] * FLIP
    np.testing.assert_allclose(delta(face, name), there, atol=0.0101)


def test_names_are_arkits_52(face):
    assert face.rig.names == ARKIT_NAMES
    assert len(set(ARKIT_NAMES)) == 52
    assert all(opposite(opposite(name)) == name for name in ARKIT_NAMES)
    assert opposite("mouthSmileLeft") == "mouthSmileRight"
    assert opposite("jawOpen") == "jawOpen"


def test_jaw_open_lowers_chin_tongue_and_lower_teeth_but_not_the_upper(face):
    jaw = delta(face, "jawOpen")
    assert jaw[chin(face), 1] < -20
    assert jaw[face.parts["lower_teeth"], 1].mean() < -10
    assert jaw[face.parts["tongue"], 1].mean() < -5
    assert not jaw[face.parts["upper_teeth"]].any()
    assert lip_gap(shape(face.rig, "jawOpen"), face) > 25


@pytest.mark.parametrize("name", ["jawOpen", "jawForward", "jawLeft"])
def test_the_lower_teeth_move_rigidly(face, name):
    ids = face.parts["lower_teeth"]
    before, after = face.rig.neutral.vertices[ids], shape(face.rig, name)[ids]
    apart = [np.linalg.norm(points[:, None] - points[None], axis=2) for points in (before, after)]
    np.testing.assert_allclose(apart[1], apart[0], atol=0.02)


def test_mouth_close_closes_the_lips_over_the_open_jaw(face):
    assert lip_gap(face.rig.neutral.vertices, face) < 1.0
    assert lip_gap(shape(face.rig, "jawOpen", "mouthClose"), face) < 2.0
    chin_at = shape(face.rig, "jawOpen", "mouthClose")[chin(face), 1]
    assert chin_at < face.rig.neutral.vertices[chin(face), 1] - 10


def test_smile_draws_the_corner_up_and_out(face):
    corner = face.contours["upper_lip"][-1]
    x, y, _ = delta(face, "mouthSmileLeft")[corner]
    assert x > 3
    assert y > 3
    assert np.abs(delta(face, "mouthSmileRight")[corner]).max() < 1


def test_brows_go_where_they_say(face):
    v = face.rig.neutral.vertices
    outer = np.linalg.norm(v - [45, 22, 85], axis=1).argmin()
    inner = np.linalg.norm(v - [12, 20, 102], axis=1).argmin()
    assert delta(face, "browOuterUpLeft")[outer, 1] > 2
    assert delta(face, "browInnerUp")[inner, 1] > 2
    assert delta(face, "browDownLeft")[inner, 1] < -2


def test_tongue_out_moves_the_tongue_alone(face):
    out = delta(face, "tongueOut")
    assert out[face.parts["tongue"], 2].max() > 15
    assert not np.delete(out, face.parts["tongue"], axis=0).any()
