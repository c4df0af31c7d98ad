"""Textures in the artist mesh's uv."""

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_map, face_mesh
from mien.blendshapes.build.artist_mesh import on_map
from mien.blendshapes.build.texture import carried_tone, expression_texture, feather, neutral_texture, texel_grid
from mien.blendshapes.correspond.dense import SkinWarp
from mien.faces import load_face
from mien.mesh import Mesh

SIZE = 256


def same() -> SkinWarp:
    rows, columns = np.mgrid[: LAYOUT.shape[0], : LAYOUT.shape[1]]
    return SkinWarp(np.stack([columns, rows], -1).astype(float), face_map().known)


@pytest.fixture(scope="module")
def grid():
    mesh = face_mesh()
    plain = Mesh(mesh.vertices, mesh.faces, mesh.uv, mesh.uv_faces, 0.6 * np.ones_like(mesh.vertices))
    skin = np.zeros(len(mesh.vertices), bool)
    skin[load_face().parts["skin"]] = True
    return texel_grid(plain, on_map(plain, face_map(), skin).shown, face_map(), SIZE)


def test_texels_are_pixels_of_the_map(grid):
    assert 0.05 < grid.shown.mean() < 0.6
    known = np.isfinite(grid.pixels[..., 0])
    assert known[grid.shown].all()


def test_the_neutral_texture_is_whole_and_the_captures_inside(grid):
    made = neutral_texture(grid, face_map())
    assert np.isfinite(made).all()
    inside = feather(grid.shown) >= 1
    wanted = face_map().at(np.nan_to_num(grid.pixels))[1]
    np.testing.assert_allclose(made[inside], wanted[inside], atol=1e-6)


def test_an_expression_of_another_exposure_is_levelled_and_the_base_elsewhere(grid):
    base = neutral_texture(grid, face_map())
    dark = face_map("dark")
    dark = type(dark)(dark.layout, dark.positions, dark.colors * 0.7, dark.confidence, "dark")
    made, seen = expression_texture(grid, dark, same(), base)
    inside = feather(grid.shown) >= 1
    np.testing.assert_allclose(made[inside & seen], base[inside & seen], atol=0.02)
    np.testing.assert_array_equal(made[~seen], base[~seen])
    blind = SkinWarp(same().pixels, np.zeros(LAYOUT.shape, bool))
    np.testing.assert_array_equal(expression_texture(grid, dark, blind, base)[0], base)


def test_the_tone_goes_on_where_nothing_was_captured():
    own = np.full((64, 64, 3), 0.5)
    seen = np.zeros((64, 64), bool)
    seen[:, :32] = True
    tone = carried_tone(np.full_like(own, 0.4), own, seen)
    np.testing.assert_allclose(tone, 0.8, atol=0.01)
