"""The artist mesh takes an expression's shape."""

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_map, face_mesh
from mien.blendshapes.build.artist_mesh import ArtistMesh, carry_on, complete, look_up, on_map
from mien.blendshapes.correspond.dense import SkinWarp
from mien.faces import load_face
from mien.mesh import Mesh, grid_faces


@pytest.fixture(scope="module")
def artist() -> ArtistMesh:
    face = load_face()
    skin = np.zeros(len(face.rig.neutral.vertices), bool)
    skin[face.parts["skin"]] = True
    return on_map(face_mesh(), face_map(), skin)


def test_vertices_on_the_surface_are_shown_and_those_behind_it_are_not(artist):
    face = load_face()
    assert artist.shown[face.regions["narrow"] > 0.9].mean() > 0.9
    assert not artist.shown[face.parts["tongue"]].any()
    np.testing.assert_allclose(artist.offsets[artist.shown], 0, atol=1.5)


def test_a_warp_that_does_nothing_gives_the_neutral_back(artist):
    rows, columns = np.mgrid[: LAYOUT.shape[0], : LAYOUT.shape[1]]
    same = SkinWarp(np.stack([columns, rows], -1).astype(float), face_map().known)
    found = look_up(artist, face_map(), same)
    seen = np.isfinite(found[:, 0])
    assert seen.sum() > 0.95 * artist.shown.sum()
    np.testing.assert_allclose(found[seen], artist.mesh.vertices[seen], atol=1e-4)
    blind = look_up(artist, face_map(), SkinWarp(same.pixels, np.zeros_like(same.shown)))
    assert np.isnan(blind).all()


def test_hidden_parts_follow_the_mix_that_fits_what_is_seen(artist):
    face = load_face()
    true = face_mesh(jawOpen=0.6).vertices
    found = np.where(artist.shown[:, None], true, np.nan)
    delta, weights = complete(artist, found, face, face.rig.deltas)
    assert abs(weights[face.rig.index("jawOpen")] - 0.6) < 0.1
    teeth = face.parts["lower_teeth"]
    np.testing.assert_allclose(delta[teeth], (true - face_mesh().vertices)[teeth], atol=1.5)
    np.testing.assert_allclose(delta[artist.shown], (true - face_mesh().vertices)[artist.shown], atol=1e-9)


def test_edges_of_lips_are_taken_where_nothing_was_found(artist):
    face = load_face()
    edges = np.full(artist.mesh.vertices.shape, np.nan)
    lip = face.contours["lower_lip"][3:-3]
    edges[lip] = [0, -5.0, 0]
    found = np.where(artist.shown[:, None], artist.mesh.vertices, np.nan)
    hidden = lip[np.isnan(found[lip, 0])]
    delta, _ = complete(artist, found, face, face.rig.deltas, edges)
    np.testing.assert_allclose(delta[hidden], np.broadcast_to([0, -5.0, 0], (len(hidden), 3)), atol=1e-6)


def test_values_are_carried_on_smoothly_and_fade():
    x, y = np.meshgrid(np.arange(60.0) * 4, np.arange(6.0) * 4)
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]))
    faces = np.concatenate([np.stack(t, 1) for t in ((a, b, c), (c, b, d))])
    mesh = Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), faces)
    known = mesh.vertices[:, 0] < 40
    out = carry_on(mesh, np.where(known[:, None], 1.0, 0.0) * np.ones(3), known)
    np.testing.assert_allclose(out[known], 1)
    assert out[np.isclose(mesh.vertices[:, 0], 44), 0].min() > 0.8
    assert np.abs(out[mesh.vertices[:, 0] > 220]).max() < 0.2


def test_a_slope_is_not_carried_on_beyond_what_is_known():
    """An open mouth's lips part ever farther towards each other; its inside must not go on so."""
    x, y = np.meshgrid(np.arange(0, 80.0, 2), np.arange(0, 20.0, 2))
    mesh = Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), grid_faces(np.stack([x, y, 0 * x], -1), 9.0))
    known = mesh.vertices[:, 0] < 20
    slope = np.where(known, 0.5 * mesh.vertices[:, 0], 0.0)[:, None] * np.ones(3)
    out = carry_on(mesh, slope, known)
    assert out.max() <= slope.max() + 1e-9
    assert out.min() >= 0
