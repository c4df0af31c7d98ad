"""The bundled face: symmetry, parts, regions, that every expression does what its name says, that people fit."""

from pathlib import Path

import numpy as np
import pytest
from trimesh import Trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

import mien.faces
from mien.faces import ARKIT_NAMES, load_face
from mien.faces.arkit import opposite
from mien.faces.lids import fit_blink, gaps, opening
from mien.stage.people.holdout_identities import load_holdout_identities

ASSETS = Path(mien.faces.__file__).parent / "assets"
FLIP = np.array([-1, 1, 1])
EIGHT = [f"{name}_{side}" for name in ("forehead", "eye", "cheek") for side in ("left", "right")] + ["mouth", "chin"]


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def people(face):
    rng = np.random.default_rng(41)
    return [face.person(rng.standard_normal(len(face.identity.modes))) for _ in range(5)]


def delta(face, name):
    return face.rig.deltas[face.rig.index(name)]


def shape(rig, *names):
    return rig.vertices(np.isin(rig.names, names).astype(float))


def chin(face):
    """The foremost vertex of the chin, on the mirror plane."""
    v = face.rig.neutral.vertices
    middle = np.flatnonzero((np.abs(v[:, 0]) < 1e-6) & (v[:, 1] < -92) & (v[:, 1] > -112))
    return middle[v[middle, 2].argmax()]


def lip_gap(vertices, face):
    """Height between the lips where they are farthest apart."""
    upper, lower = (vertices[face.contours[name]] for name in ("upper_lip", "lower_lip"))
    inner = upper[2:-2]
    order = np.argsort(lower[:, 0])
    return (inner[:, 1] - np.interp(inner[:, 0], lower[order, 0], lower[order, 1])).max()


# --- symmetry ---------------------------------------------------------------------------------------------------------


def test_mirror_is_an_involution(face):
    np.testing.assert_array_equal(face.mirror[face.mirror], np.arange(len(face.mirror)))


def test_neutral_is_its_own_mirror_image_exactly(face):
    v = face.rig.neutral.vertices
    np.testing.assert_array_equal(v[face.mirror] * FLIP, v)


def test_triangles_are_mirrored_too(face):
    def keys(faces):
        return {frozenset(triangle) for triangle in faces.tolist()}

    faces = face.rig.neutral.faces
    skin = np.isin(faces, face.parts["skin"]).all(1)
    assert keys(face.mirror[faces[skin]]) == keys(faces[skin])


@pytest.mark.parametrize("name", ARKIT_NAMES)
def test_each_shape_is_the_mirror_image_of_its_opposite(face, name):
    there = delta(face, opposite(name))[face.mirror] * FLIP
    np.testing.assert_allclose(delta(face, name), there, atol=0.0101)


def test_identity_modes_are_symmetric_or_antisymmetric(face):
    for mode in face.identity.modes:
        image = mode[face.mirror] * FLIP
        assert min(np.abs(image - mode).max(), np.abs(image + mode).max()) < 0.01


# --- names, parts, regions --------------------------------------------------------------------------------------------


def test_names_are_arkits_52(face):
    assert face.rig.names == ARKIT_NAMES
    assert len(set(ARKIT_NAMES)) == 52
    assert all(opposite(opposite(name)) == name for name in ARKIT_NAMES)
    assert opposite("mouthSmileLeft") == "mouthSmileRight"
    assert opposite("jawOpen") == "jawOpen"


def test_parts_hold_every_vertex_once(face):
    together = np.sort(np.concatenate(list(face.parts.values())))
    np.testing.assert_array_equal(together, np.arange(len(face.rig.neutral.vertices)))
    for part in face.parts.values():
        inside = np.isin(face.rig.neutral.faces, part).sum(1)
        assert set(inside.tolist()) <= {0, 3}


def test_regions_lie_on_the_outer_skin_in_0_to_1(face):
    off = np.concatenate([ids for name, ids in face.parts.items() if name != "skin"])
    for mask in face.regions.values():
        assert mask.min() == 0
        assert 0.9 < mask.max() <= 1
        assert not mask[off].any()


def test_eight_regions_cover_the_face_and_overlap(face):
    eight = np.stack([face.regions[name] for name in EIGHT])
    np.testing.assert_allclose(eight.max(0), face.regions["face"], atol=0.02)
    on_face = face.regions["face"] > 0.9
    shared = (eight[:, on_face] > 0.05).sum(0)
    assert 0.2 < (shared > 1).mean() < 0.9


def test_left_and_right_regions_are_mirror_images(face):
    for name in ("forehead", "eye", "cheek"):
        left, right = face.regions[name + "_left"], face.regions[name + "_right"]
        np.testing.assert_array_equal(left[face.mirror], right)
        assert (left * face.rig.neutral.vertices[:, 0]).sum() > 0


def test_the_face_ends_at_hairline_jaw_and_ears(face):
    on_face = face.rig.neutral.vertices[face.regions["face"] > 0.5]
    narrow = face.rig.neutral.vertices[face.regions["narrow"] > 0.5]
    assert 50 < on_face[:, 1].max() < 75
    assert -120 < on_face[:, 1].min() < -95
    assert on_face[:, 2].min() > 5
    assert narrow[:, 2].min() > on_face[:, 2].min() + 10
    assert narrow[:, 1].max() < on_face[:, 1].max() - 10


def test_inside_of_the_mouth_is_no_face(face):
    v = face.rig.neutral.vertices
    deep = (np.abs(v[:, 0]) < 20) & (np.abs(v[:, 1] + 70) < 15) & (v[:, 2] < 85) & (v[:, 2] > 30)
    assert deep.sum() > 100
    assert face.regions["face"][deep].max() < 0.05


def test_uv_lies_in_the_unit_square_and_every_triangle_is_upright(face):
    mesh = face.rig.neutral
    assert mesh.uv.min() >= 0
    assert mesh.uv.max() <= 1
    skin = np.isin(mesh.faces, np.flatnonzero(face.regions["face"] > 0.5)).all(1)
    a, b, c = np.moveaxis(mesh.uv[mesh.uv_faces[skin]], 1, 0)
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    assert (area > 0).mean() > 0.98


# --- known truth: space and size --------------------------------------------------------------------------------------


def test_origin_lies_80_mm_behind_the_middle_between_the_eyes(face):
    v = face.rig.neutral.vertices
    left, right = face.eyeball(v, "left")[0], face.eyeball(v, "right")[0]
    np.testing.assert_allclose((left + right) / 2, [0, 0, 80], atol=1e-4)
    assert left[0] > 0


def test_the_average_has_human_measures(face):
    v = face.rig.neutral.vertices
    pupils = face.eyeball(v, "left")[0][0] * 2
    assert 56 < pupils < 66
    nose = np.abs(v[:, 0]) < 1e-6
    tip = v[nose][v[nose, 2].argmax()]
    assert 110 < tip[2] < 135
    assert -50 < tip[1] < -25
    level = np.abs(v[:, 1] + 20) < 10
    assert 130 < 2 * np.abs(v[level & (v[:, 2] > 20), 0]).max() < 155


# --- known truth: expressions -----------------------------------------------------------------------------------------


def test_left_is_the_subjects_left(face):
    x = face.rig.neutral.vertices[:, 0]
    for name in ("mouthSmileLeft", "eyeBlinkLeft", "browDownLeft", "noseSneerLeft", "cheekSquintLeft"):
        size = np.linalg.norm(delta(face, name), axis=1)
        assert (size * x).sum() > 0.5 * (size * np.abs(x)).sum()
    assert delta(face, "jawLeft")[chin(face), 0] > 3
    assert delta(face, "mouthLeft")[face.contours["upper_lip"][9], 0] > 3


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


# --- people -----------------------------------------------------------------------------------------------------------


def test_nobody_in_particular_is_the_average(face):
    rig = face.person(np.zeros(3))
    np.testing.assert_array_equal(rig.neutral.vertices, face.rig.neutral.vertices)
    np.testing.assert_allclose(rig.deltas, face.rig.deltas, atol=0.7)


def test_people_lie_evenly_about_the_average(face):
    c = np.random.default_rng(3).standard_normal(len(face.identity.modes))
    both = face.person(c).neutral.vertices + face.person(-c).neutral.vertices
    np.testing.assert_allclose(both / 2, face.rig.neutral.vertices, atol=1e-9)


def test_fewer_coefficients_are_the_first_ones(face):
    c = np.array([0.5, -1.0])
    padded = np.concatenate([c, np.zeros(len(face.identity.modes) - 2)])
    np.testing.assert_allclose(face.identity.displacement(c), face.identity.displacement(padded), atol=1e-12)


def test_too_many_coefficients_are_refused(face):
    with pytest.raises(ValueError, match=f"at most {len(face.identity.modes)}, got 500"):
        face.person(np.zeros(500))


def test_modes_come_strongest_first_and_bring_no_turn(face):
    region = face.regions["face"] > 0.5
    size = np.sqrt((face.identity.modes[:, region] ** 2).sum((1, 2)))
    assert size[0] == size.max()
    assert size[:10].min() > size[40:].max()
    v = face.rig.neutral.vertices[region]
    spokes = v - v.mean(0)
    for mode in face.identity.modes:
        turn = np.cross(spokes, mode[region]).sum(0) / (spokes**2).sum()
        assert np.degrees(np.abs(turn)).max() < 2


def test_people_differ_by_millimetres_and_stay_human(face, people):
    region = face.regions["face"] > 0.5
    average = face.rig.neutral.vertices
    for rig in people:
        apart = np.linalg.norm(rig.neutral.vertices - average, axis=1)[region]
        assert 1.5 < apart.mean() < 12
        assert apart.max() < 35


# --- lids by hand -----------------------------------------------------------------------------------------------------


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


# --- files ------------------------------------------------------------------------------------------------------------


def test_holdout_identities_lie_outside_the_identity_space(face):
    names, fields = load_holdout_identities()
    assert len(names) == len(set(names)) == len(fields) > 60
    assert fields.shape[1:] == face.rig.neutral.vertices.shape
    region = face.regions["face"] > 0.5
    basis, _ = np.linalg.qr(face.identity.modes[:, region].reshape(len(face.identity.modes), -1).T)
    flat = fields[:, region].reshape(len(fields), -1)
    size = np.linalg.norm(flat, axis=1)
    moving = size > 1
    outside = np.linalg.norm(flat - (flat @ basis) @ basis.T, axis=1)[moving] / size[moving]
    assert np.median(outside) > 0.3


def test_assets_are_small_and_say_whose_they_are():
    assert sum(path.stat().st_size for path in ASSETS.iterdir()) < 5e6
    assert "CC0 1.0 Universal" in (ASSETS / "LICENSE.md").read_text()
    assert "MakeHuman" in (ASSETS / "README.md").read_text()


def test_colours_tell_lips_eyes_and_skin_apart(face):
    colours = face.rig.neutral.colors
    pupil, back = colours[face.parts["left_eye"][[0, -1]]]
    assert pupil.max() < 0.1
    assert back.min() > 0.8
    lip, forehead = colours[face.contours["lower_lip"][7]], colours[face.regions["forehead_left"].argmax()]
    assert lip[0] - lip[1] > forehead[0] - forehead[1] + 0.05
