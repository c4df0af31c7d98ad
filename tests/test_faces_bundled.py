"""The bundled face."""

from pathlib import Path

import numpy as np
import pytest

import mien.faces
from mien.faces import load_face
from whole_face import FLIP, chin, delta

ASSETS = Path(mien.faces.__file__).parent / "assets"


EIGHT = [f"{name}_{side}" for name in ("forehead", "eye", "cheek") for side in ("left", "right")] + ["mouth", "chin"]


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def people(face):
    rng = np.random.default_rng(41)
    return [face.person(rng.standard_normal(len(face.identity.modes))) for _ in range(5)]


def test_mirror_is_an_involution(face):
    np.testing.assert_array_equal(face.mirror[face.mirror], np.arange(len(face.mirror)))


def test_neutral_is_its_own_mirror_image_exactly(face):
    v = face.rig.neutral.vertices
    np.testing.assert_array_equal(v[face.mirror] * FLIP, v)


def test_triangles_are_mirrored_too(face):
    def keys(faces):
        return {frozenset(triangle) for triangle in faces.tolist()}

    faces, skin = face.rig.neutral.faces, face.skin_faces
    np.testing.assert_array_equal(np.unique(faces[skin]), face.parts["skin"])
    np.testing.assert_array_equal(np.flatnonzero(face.on_skin), face.parts["skin"])
    assert keys(face.mirror[faces[skin]]) == keys(faces[skin])


def test_identity_modes_are_symmetric_or_antisymmetric(face):
    for mode in face.identity.modes:
        image = mode[face.mirror] * FLIP
        assert min(np.abs(image - mode).max(), np.abs(image + mode).max()) < 0.01


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


def test_left_is_the_subjects_left(face):
    x = face.rig.neutral.vertices[:, 0]
    for name in ("mouthSmileLeft", "eyeBlinkLeft", "browDownLeft", "noseSneerLeft", "cheekSquintLeft"):
        size = np.linalg.norm(delta(face, name), axis=1)
        assert (size * x).sum() > 0.5 * (size * np.abs(x)).sum()
    assert delta(face, "jawLeft")[chin(face), 0] > 3
    assert delta(face, "mouthLeft")[face.contours["upper_lip"][9], 0] > 3


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
