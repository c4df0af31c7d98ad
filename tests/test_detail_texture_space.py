from dataclasses import replace

import numpy as np
import pytest

from detail_patch import patch
from mien.detail.texture_space import (
    resampling,
    sample,
    tangent_frames,
    texel_mm,
    texels,
    texture_gradients,
    with_gutter,
    with_texture,
)
from mien.errors import BadInput


def test_texels_lie_where_their_coordinates_say():
    mesh = patch()
    grid = texels(mesh, 64)
    at = np.einsum("pc,pcd->pd", grid.attachment.barycentric, mesh.uv[mesh.faces[grid.attachment.faces]])
    row, column = np.divmod(grid.pixels, 64)
    np.testing.assert_allclose(at, np.stack([(column + 0.5) / 64, 1 - (row + 0.5) / 64], 1), atol=1e-9)


def test_images_come_back():
    grid = texels(patch(), 32)
    values = np.random.default_rng(1).normal(size=(len(grid.pixels), 2))
    image = grid.image(values)
    assert np.isnan(image[0, 0]).all()
    np.testing.assert_array_equal(grid.of_image(image), values)


def test_gradients_of_a_linear_map_by_hand():
    """P = (30 u, 20 v, 0): dP/du = (30, 0, 0), dP/dv = (0, 20, 0) everywhere; the normal is +Z."""
    mesh = patch(9)
    flat = np.column_stack([30 * mesh.uv[:, 0], 20 * mesh.uv[:, 1], np.zeros(81)])
    u, v = texture_gradients(mesh)
    np.testing.assert_allclose(u @ flat, np.tile([30, 0, 0], (81, 1)), atol=1e-9)
    np.testing.assert_allclose(v @ flat, np.tile([0, 20, 0], (81, 1)), atol=1e-9)
    np.testing.assert_allclose(tangent_frames((u, v), flat), np.tile(np.eye(3), (81, 1, 1)), atol=1e-9)


def test_frames_turn_with_the_surface():
    mesh, turn = patch(9), np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    gradients = texture_gradients(mesh)
    still, turned = (tangent_frames(gradients, x) for x in (mesh.vertices, mesh.vertices @ turn.T))
    np.testing.assert_allclose(turned, still @ turn.T, atol=1e-9)


def test_sampling_a_ramp_is_exact_and_the_gutter_holds():
    grid = texels(patch(), 48)
    row, column = np.divmod(grid.pixels, 48)
    ramp = with_gutter(grid.image(0.3 * column + 0.7 * row))
    uv = np.random.default_rng(2).uniform(0.1, 0.9, (50, 2))
    np.testing.assert_allclose(sample(ramp, uv), 0.3 * (uv[:, 0] * 48 - 0.5) + 0.7 * ((1 - uv[:, 1]) * 48 - 0.5))
    assert np.isfinite(ramp).all()


def test_a_mesh_without_coordinates_is_unrolled_one_to_one():
    mesh = with_texture(replace(patch(17), uv=None))
    assert mesh.uv is not None
    assert mesh.uv.min() >= 0
    assert mesh.uv.max() <= 1
    a, b, c = (mesh.uv[mesh.faces[:, i]] for i in range(3))
    along, across = b - a, c - a
    assert (along[:, 0] * across[:, 1] > along[:, 1] * across[:, 0]).all()


def test_coordinates_off_the_image_are_refused():
    mesh = patch(9)
    with pytest.raises(BadInput, match="no texel"):
        texels(replace(mesh, uv=mesh.uv + 5), 16)


def test_resampling_reads_a_ramp_as_sampling_does():
    mesh = patch()
    coarse, fine = texels(mesh, 24), texels(mesh, 60)
    ramp = (coarse.pixels % 24).astype(float)
    uv = np.einsum("pc,pcd->pd", fine.attachment.barycentric, mesh.uv[mesh.faces[fine.attachment.faces]])
    expected = sample(with_gutter(coarse.image(ramp)), uv)
    np.testing.assert_allclose(resampling(mesh, coarse, fine) @ ramp, expected, atol=1e-4)


def test_texels_have_their_size():
    assert texel_mm(patch(), 64) == pytest.approx(60 / 0.9 / 64 * 1.06, rel=0.05)
