"""The performer: laws of the nonlinear face, and that it is nobody whom the bundled face can be."""

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.faces.lids import gaps
from mien.stage import STRANGER, PerformerConfig, StyleConfig, make_performer
from mien.stage.people.anatomy import rigid_motion
from mien.stage.people.make_performer import LIP_OVERLAP

NO_STYLE = StyleConfig(gain=0.0, turn=0.0, extra=0.0, bow=0.0, saturation=0.0, mixing=0.0)


@pytest.fixture(scope="module", params=[PerformerConfig(), STRANGER], ids=["bent", "muscles"])
def config(request):
    return request.param


@pytest.fixture(scope="module")
def performer(config):
    return make_performer(2, config)


def pose(performer, **units):
    weights = np.zeros((1, len(performer.names)))
    for name, value in units.items():
        sides = [name] if name in performer.names else [f"{name}Left", f"{name}Right"]
        weights[0, [performer.names.index(s) for s in sides]] = value
    return weights


def test_zero_weights_give_the_neutral_face(performer):
    out = performer.vertices(np.zeros((2, 52)))
    np.testing.assert_allclose(out, np.broadcast_to(performer.neutral.vertices, out.shape), atol=1e-10)


def test_the_same_seed_is_the_same_person_and_another_is_not(performer, config):
    again, other = make_performer(2, config), make_performer(3, config)
    weights = np.full((1, 52), 0.3)
    np.testing.assert_array_equal(again.vertices(weights), performer.vertices(weights))
    assert np.abs(other.neutral.vertices - performer.neutral.vertices).max() > 3


def test_chunks_do_not_matter(performer):
    weights = np.random.default_rng(0).random((130, 52)) * 0.4
    np.testing.assert_allclose(performer.vertices(weights)[[3, 127]], performer.vertices(weights[[3, 127]]), atol=1e-9)
    streamed = np.stack([v for v, _ in zip(performer.stream(weights), range(4), strict=False)])
    np.testing.assert_allclose(streamed, performer.vertices(weights[:4]), atol=1e-9)


def test_without_shape_and_style_a_small_unit_is_the_bundled_one():
    face = load_face()
    plain = make_performer(0, PerformerConfig(identity=0.0, holdout=0.0, displacement=0.0, style=NO_STYLE))
    weights = pose(plain, mouthSmile=0.3, browInnerUp=0.5)
    skin = face.regions["face"] > 0.5
    moved = (plain.vertices(weights)[0] - plain.neutral.vertices)[skin]
    generic = (face.rig.vertices(weights)[0] - face.rig.neutral.vertices)[skin]
    assert np.linalg.norm(moved - generic, axis=1).mean() < 0.02


def test_the_neutral_face_is_outside_the_identity_space(performer):
    face = load_face()
    skin = face.regions["face"] > 0.5
    shape = (performer.neutral.vertices - face.rig.neutral.vertices)[skin].ravel()
    modes = face.identity.modes[:, skin].reshape(len(face.identity.modes), -1)
    rigid = np.concatenate([np.tile(np.eye(3), (1, skin.sum())), _turns(face.rig.neutral.vertices[skin])])
    basis = np.concatenate([modes, rigid]).T
    residual = shape - basis @ np.linalg.lstsq(basis, shape, rcond=None)[0]
    assert np.sqrt((residual.reshape(-1, 3) ** 2).sum(axis=1).mean()) > 0.6


def _turns(points):
    return np.stack([np.cross(axis, points).ravel() for axis in np.eye(3)])


def test_expressions_are_outside_the_bundled_rig(performer):
    face = load_face()
    skin = face.regions["face"] > 0.5
    weights = pose(performer, mouthSmile=0.8, cheekSquint=0.5, browInnerUp=0.6, jawOpen=0.3)
    moved = (performer.vertices(weights)[0] - performer.neutral.vertices)[skin].ravel()
    shapes = face.rig.deltas[:, skin].reshape(52, -1).T
    left = moved - shapes @ np.linalg.lstsq(shapes, moved, rcond=None)[0]
    share = np.linalg.norm(left) / np.linalg.norm(moved)
    assert 0.05 < share < 0.5


def test_a_pair_of_units_is_not_the_sum_of_the_two(performer):
    rest = performer.neutral.vertices
    smile, raised = pose(performer, mouthSmile=0.8), pose(performer, mouthUpperUp=0.8)
    apart = performer.vertices(smile)[0] + performer.vertices(raised)[0] - 2 * rest
    together = performer.vertices(smile + raised)[0] - rest
    assert np.linalg.norm(together - apart, axis=1).max() > 0.3


@pytest.mark.parametrize("name", ["left_eye", "right_eye", "upper_teeth", "lower_teeth"])
def test_eyes_and_teeth_move_as_bodies(performer, name):
    part = load_face().parts[name]
    out = performer.vertices(pose(performer, jawOpen=0.7, jawLeft=0.4, eyeLookOutLeft=0.8, eyeLookInRight=0.8))[0]
    R, t = rigid_motion(performer.neutral.vertices[part], out[part])
    np.testing.assert_allclose(out[part], performer.neutral.vertices[part] @ R.T + t, atol=1e-9)
    if name == "lower_teeth":
        assert np.arccos((np.trace(R) - 1) / 2) > 0.15


def test_the_jaw_travels_on_an_arc(performer):
    teeth = load_face().parts["lower_teeth"]
    half, whole = (performer.vertices(pose(performer, jawOpen=w))[0][teeth].mean(0) for w in (0.5, 1.0))
    rest = performer.neutral.vertices[teeth].mean(axis=0)
    assert np.linalg.norm(half - (rest + whole) / 2) > 0.5


@pytest.mark.parametrize("also", [{}, {"eyeSquint": 1.0}, {"mouthSmile": 0.8, "cheekSquint": 0.7}, {"browDown": 1.0}])
def test_lids_close_on_a_blink(performer, also):
    face = load_face()
    out = performer.vertices(pose(performer, eyeBlink=1.0, **also))[0]
    for side in ("left", "right"):
        lids = face.contours[f"{side}_upper_lid"], face.contours[f"{side}_lower_lid"]
        assert gaps(performer.neutral.vertices, *lids).max() > 5
        assert gaps(out, *lids).max() < 0.3


def test_lids_slide_over_the_ball(performer):
    for w in np.linspace(0, 1, 6):
        out = performer.vertices(pose(performer, eyeBlink=w, eyeSquint=0.3 * (1 - w)))[0]
        for side, ball in performer.eyes.items():
            upper, _ = performer.lids[side].points(out)
            assert np.linalg.norm(upper - ball.centre, axis=1).min() > ball.radius - 0.01


@pytest.mark.parametrize(
    "units",
    [
        {}, {"mouthPress": 1.0}, {"mouthPucker": 1.0}, {"mouthShrugLower": 1.0}, {"mouthSmile": 0.8},
        {"jawOpen": 0.5, "mouthClose": 0.5}, {"mouthFrown": 0.7, "mouthShrugLower": 0.5},
    ],
)  # fmt: skip
def test_closed_lips_meet_and_do_not_pass_through_one_another(performer, config, units):
    pressed = LIP_OVERLAP if config.warps else 0.0
    out = performer.vertices(pose(performer, **units))[0]
    upper, lower = performer.lips.points(out)
    gap = ((upper - lower) * performer.lips.normal).sum(axis=1)
    assert gap.min() > (-6 if "mouthShrugLower" in units else -0.8 - pressed)
    assert np.median(gap) < 0.5 + pressed
