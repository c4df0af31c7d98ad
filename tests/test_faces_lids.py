"""Lids over eyeballs."""

import numpy as np
import pytest
from trimesh import Trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from mien.faces import load_face
from mien.faces.lids import fit_blink, gaps, opening
from whole_face import shape


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def people(face):
    rng = np.random.default_rng(41)
    return [face.person(rng.standard_normal(len(face.identity.modes))) for _ in range(5)]


@pytest.mark.parametrize(
    ("look", "axis", "sign", "degrees"),
    [("Out", 0, 1, 25), ("In", 0, -1, 25), ("Up", 1, 1, 15), ("Down", 1, -1, 20)],
)
def test_eyes_turn_about_their_centres(face, people, look, axis, sign, degrees):
    for rig in (face.rig, people[0]):
        neutral, turned = rig.neutral.vertices, shape(rig, f"eyeLook{look}Left")
        (before, radius), (after, same) = face.eyeball(neutral, "left"), face.eyeball(turned, "left")
        np.testing.assert_allclose(after, before, atol=0.05)
        np.testing.assert_allclose(same, radius, atol=0.05)
        pupil = face.parts["left_eye"][0]
        straight, gaze = (neutral[pupil] - before) / radius, (turned[pupil] - after) / same
        assert np.sign(gaze[axis] - straight[axis]) == sign
        np.testing.assert_allclose(np.degrees(np.arccos(straight @ gaze)), degrees, atol=0.5)


def test_eyeballs_are_round_and_fill_the_opening(face, people):
    for rig in (face.rig, *people):
        v = rig.neutral.vertices
        centre, radius = face.eyeball(v, "right")
        spokes = np.linalg.norm(v[face.parts["right_eye"]] - centre, axis=1)
        np.testing.assert_allclose(spokes, radius, atol=0.15)
        lids = np.concatenate([face.contours["right_upper_lid"], face.contours["right_lower_lid"]])
        clear = np.linalg.norm(v[lids] - centre, axis=1) - radius
        assert -0.3 < clear.min() < clear.mean() < 3


def seen_eyeball(face, vertices):
    """Square millimetres of eyeball seen from straight ahead."""
    faces = face.rig.neutral.faces
    eyes = np.isin(faces, np.concatenate([face.parts["left_eye"], face.parts["right_eye"]])).all(1)
    x, y = np.meshgrid(np.arange(-55, 55, 0.5), np.arange(-22, 22, 0.5))
    start = np.stack([x.ravel(), y.ravel(), np.full(x.size, 300.0)], 1)
    caster = RayMeshIntersector(Trimesh(vertices, faces, process=False))
    hit = caster.intersects_first(start, np.tile([0.0, 0.0, -1.0], (len(start), 1)))
    return eyes[hit[hit >= 0]].sum() * 0.25


def test_blink_hides_the_eyes_of_the_average_and_of_others(face, people):
    for rig in (face.rig, *people):
        assert seen_eyeball(face, rig.neutral.vertices) > 60
        closed = shape(rig, "eyeBlinkLeft", "eyeBlinkRight")
        assert seen_eyeball(face, closed) == 0
        for side in ("left", "right"):
            lids = face.contours[f"{side}_upper_lid"], face.contours[f"{side}_lower_lid"]
            assert gaps(closed, *lids).max() < 1.0
            assert gaps(closed, *lids).min() > -3.5


@pytest.mark.parametrize("travel", [4.0, 10.0, 14.0])
def test_a_blink_is_fitted_to_the_opening(travel):
    x = np.linspace(-10, 10, 11)
    bow = 5 * (1 - (x / 10) ** 2)
    vertices = np.concatenate([np.stack([x, bow, 0 * x], 1), np.stack([x, -bow, 0 * x], 1)[1:-1]])
    upper, lower = np.arange(11), np.r_[0, np.arange(11, 20), 10]
    blink = np.zeros_like(vertices)
    blink[upper, 1] = -travel * (1 - (x / 10) ** 2)
    np.testing.assert_allclose(opening(vertices, upper, lower), 2 * bow[1:-1].mean(), atol=1e-12)
    fitted = fit_blink(vertices, blink, upper, lower, np.array([0.0, 0.0, -2000.0]))
    left = gaps(vertices + fitted, upper, lower)
    assert left.max() < 0.05
    assert left.min() > -1.2
    assert not fitted[11:].any()
