"""The head of every scan told from skin that hardly moves."""

import numpy as np

from mien.faces import load_face
from mien.register import procrustes
from mien.scans.correspond.still_skin import StillSkinConfig, moved_shapes, settle_heads, stillness
from mien.transforms import Transform, rotation_from_vector
from small_scans import bundled_template as template
from small_scans import front_of

TURN = Transform(rotation_from_vector(np.array([0.01, -0.008, 0.006])), np.array([0.4, -0.8, 0.5]))


def expression() -> np.ndarray:
    """An open, smiling mouth under raised brows, head still: face space, mm."""
    rig = load_face().rig
    names = ("jawOpen", "mouthSmileLeft", "mouthSmileRight", "browInnerUp")
    deltas = sum(0.7 * rig.deltas[rig.index(name)] for name in names)
    return template().skin.vertices + deltas[template().members]


def apart(T: Transform, other: Transform) -> float:
    skin = template().skin.vertices[template().regions["face"] > 0.5]
    return float(np.linalg.norm(T.apply(skin) - other.apply(skin), axis=1).mean())


def test_a_moved_head_comes_back_under_a_strong_expression():
    rest, front = template().skin, template().regions["face"] > 0.01
    moved = TURN.apply(expression())
    shapes = np.stack([rest.vertices, moved])
    still, found = settle_heads(template(), shapes, front_of(rest))
    assert apart(still, Transform.identity()) == 0.0
    assert apart(found, TURN.inverse()) < 0.15
    everything = procrustes(moved[front], rest.vertices[front]).transform
    assert apart(everything, TURN.inverse()) > 0.5
    np.testing.assert_allclose(moved_shapes([still, found], shapes)[1], found.apply(moved))


def test_the_neck_and_the_mouth_say_nothing_and_the_forehead_much():
    weights, mesh = stillness(template(), StillSkinConfig()), template().skin
    lowest = mesh.vertices[template().regions["mouth"] > 0.5, 1].max()
    assert weights[mesh.vertices[:, 1] < lowest].max() == 0
    mobile = template().mobility > 1.0
    forehead = (template().regions["forehead_left"] > 0.5) & ~mobile
    assert weights[mobile].max() < 0.1 * weights[forehead].max()


def test_where_no_skin_is_left_or_it_is_switched_off_nothing_moves():
    rest = template().skin
    shapes = np.stack([rest.vertices, TURN.apply(rest.vertices)])
    far = rest.with_vertices(rest.vertices + 500.0)
    for scan, config in ((far, StillSkinConfig()), (rest, StillSkinConfig(enabled=False))):
        for T in settle_heads(template(), shapes, scan, config):
            np.testing.assert_array_equal(T.rotation, np.eye(3))
