"""Skin: strain by hand, buckling, wrinkles that come with compression, and vertices that know what they were."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import Mesh
from mien.stage import Skin, SkinConfig, make_performer, make_skin, marker_layout, perform
from mien.stage.people.strain import strain_gauge
from mien.stage.people.wrinkles import buckling, furrows
from mien.stage.sensors.mocap import MocapConfig
from mien.transforms import rotation_from_vector


@pytest.fixture(scope="module")
def skin() -> Skin:
    return make_skin(make_performer(5), SkinConfig(levels=1))


def pose(skin, **units):
    weights = np.zeros(52)
    for name, value in units.items():
        sides = [name] if name in skin.names else [f"{name}Left", f"{name}Right"]
        weights[[skin.names.index(s) for s in sides]] = value
    return weights


def sheet():
    """A 4 x 4 grid of points in the plane z = 0, and its triangles."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(16)], axis=1)
    quads = [(i, i + 1, i + 5, i + 4) for j in range(3) for i in range(4 * j, 4 * j + 3)]
    return Mesh(points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2])
def test_a_gauge_reads_a_known_compression(angle):
    mesh = sheet()
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    gauge = strain_gauge(mesh, np.arange(len(mesh.faces)), np.tile(along, (len(mesh.faces), 1)))
    squeezed = mesh.vertices - 0.2 * (mesh.vertices @ along)[:, None] * along
    turned = squeezed @ rotation_from_vector(np.array([0.3, -1.0, 0.5])).T + [5.0, 6.0, 7.0]
    np.testing.assert_allclose(gauge.compression(np.stack([mesh.vertices, squeezed, turned])), 
                               np.array([[0.0], [0.2], [0.2]]) * np.ones(16), atol=1e-12)  # fmt: skip
    across = mesh.vertices * 1.0
    across -= 0.3 * (across @ [-along[1], along[0], 0.0])[:, None] * np.array([-along[1], along[0], 0.0])
    np.testing.assert_allclose(gauge.compression(across[None]), 0.0, atol=1e-12)


def test_skin_buckles_past_its_threshold_alone_and_as_a_root():
    np.testing.assert_array_equal(buckling(np.array([-0.2, 0.0, 0.03]), 0.03), 0.0)
    small = buckling(np.array([0.03 + 1e-6, 0.03 + 4e-6]), 0.03)
    np.testing.assert_allclose(small[1] / small[0], 2.0, rtol=1e-3)
    assert 0.9 < buckling(np.array([0.5]), 0.03)[0] <= 1.0


def test_furrows_have_no_mean_and_are_narrower_than_folds():
    profile = furrows(np.linspace(0, 2 * np.pi, 1001)[:-1])
    np.testing.assert_allclose(profile.mean(), 0.0, atol=1e-6)
    np.testing.assert_allclose(profile.min(), -1.0)
    assert (profile < -0.3).mean() < 0.25


def test_brows_raise_the_forehead_and_nothing_else(skin):
    forehead = np.abs(skin.patterns[0].relief) > 0.3
    chin = np.abs(skin.patterns[-1].relief) > 0.3
    rest, up = skin.height(pose(skin)), skin.height(pose(skin, browInnerUp=1.0, browOuterUp=1.0))
    assert up[forehead].std() > 3 * rest[forehead].std()
    np.testing.assert_allclose(up[chin], rest[chin], atol=0.01)
    assert 0.2 < np.abs(up).max() < 1.4


def test_smiles_fold_the_corners_of_the_eyes_and_mouth(skin):
    smile = skin.height(pose(skin, mouthSmile=0.9, cheekSquint=0.8))
    rest = skin.height(pose(skin))
    for pattern in skin.patterns[3:7]:
        there = np.abs(pattern.relief) > 0.2
        assert np.abs(smile - rest)[there].max() > 0.1, pattern.name


def test_vertices_at_rest_and_in_part(skin):
    np.testing.assert_allclose(skin.vertices(np.zeros((1, 52)))[0], skin.neutral.vertices, atol=1e-9)
    weights = np.stack([pose(skin, browDown=0.8), pose(skin, mouthSmile=0.7, jawOpen=0.3)])
    rows = np.random.default_rng(0).choice(len(skin.neutral.vertices), 200, replace=False)
    np.testing.assert_allclose(skin.vertices(weights, rows), skin.vertices(weights)[:, rows], atol=1e-9)


def test_every_vertex_knows_its_place_in_the_bundled_topology(skin):
    kept = np.flatnonzero(skin.bundled >= 0)
    assert len(kept) > 2500
    straight = skin.straight[skin.bundled[kept]]
    np.testing.assert_array_equal(straight.indices, kept)
    np.testing.assert_allclose(np.asarray(skin.straight.sum(axis=1)).ravel(), 1.0)
    np.testing.assert_allclose(np.asarray(skin.smooth.sum(axis=1)).ravel(), 1.0)
    moved = np.linalg.norm(skin.neutral.vertices - skin.straight @ skin.performer.neutral.vertices, axis=1)
    assert np.percentile(moved, 95) < 2.0


def test_colours_are_colours_and_brows_are_dark(skin):
    colors = skin.neutral.colors
    assert colors is not None
    assert colors.min() >= 0
    assert colors.max() <= 1
    assert np.unique(colors.round(3), axis=0).shape[0] > 1000


def test_squeezed_skin_reddens_and_the_rest_keeps_its_colour(skin):
    rest, smile = skin.colors(pose(skin)), skin.colors(pose(skin, mouthSmile=0.9, cheekSquint=0.7))
    np.testing.assert_allclose(rest, skin.neutral.colors)
    redder = (smile - rest)[:, 0] - (smile - rest)[:, 1]
    points = skin.neutral.vertices
    brow = (points[:, 1] > 30) & (points[:, 2] > 35)
    assert redder.max() > 0.05
    assert redder.min() < -0.02
    assert np.abs(redder[brow]).max() < 0.02


def test_no_wrinkles_and_no_pores_leave_the_smooth_surface():
    plain = make_skin(make_performer(5), SkinConfig(levels=1, wrinkles=0.0, pores=0.0))
    weights = pose(plain, browInnerUp=1.0, browOuterUp=1.0)
    np.testing.assert_array_equal(plain.height(weights), 0.0)
    coarse = plain.performer.vertices(weights[None])[0]
    np.testing.assert_allclose(plain.vertices(weights[None])[0], plain.smooth @ coarse, atol=1e-12)


def test_markers_sit_on_the_skin_itself(skin):
    clean = MocapConfig(jitter=0.0, dropouts=0.0, standoff=(0.0, 0.0))
    weights = np.stack([pose(skin), pose(skin, browInnerUp=1.0, mouthSmile=0.6)])
    take = perform(skin, weights, 60.0, marker_layout(skin, 30), clean)
    on_skin = take.truth.attachment.points(skin.mesh(weights[1]))
    np.testing.assert_allclose(take.markers.positions[1], take.truth.T_lab_face[1].apply(on_skin), atol=1e-9)


def test_too_many_levels_are_refused():
    with pytest.raises(BadInput, match="levels"):
        make_skin(make_performer(5), SkinConfig(levels=9))
