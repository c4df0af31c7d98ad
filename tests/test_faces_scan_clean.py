"""What is done to a scan before anything is fitted to it, on a cube by hand."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces.scan_clean import (
    ROUGH_DEG,
    check_scan,
    cleaned,
    evened,
    fork_edges,
    mended,
    roughness_deg,
    welded,
)
from mien.mesh import Mesh, Scan, face_normals, grid_faces

CORNERS = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
SQUARES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
CUBE = Mesh(CORNERS, np.concatenate([SQUARES[:, [0, 1, 2]], SQUARES[:, [0, 2, 3]]]))


def outward_share(mesh: Mesh) -> float:
    normals, middles = face_normals(mesh.vertices, mesh.faces), mesh.vertices[mesh.faces].mean(axis=1)
    return float((np.einsum("fd,fd->f", normals, middles - mesh.vertices.mean(axis=0)) > 0).mean())


def test_triangles_that_share_no_vertex_are_joined():
    soup = Mesh(CUBE.vertices[CUBE.faces].reshape(-1, 3), np.arange(36).reshape(12, 3))
    assert len(welded(soup).vertices) == 8
    fixed, notes = mended(soup)
    assert len(fixed.faces) == 12
    assert notes[0] == "28 duplicated vertices made one with their twins"


def test_flat_and_double_triangles_go():
    more = np.concatenate([CUBE.faces, CUBE.faces[:2], [[0, 0, 1]]])
    assert len(welded(Mesh(CUBE.vertices, more)).faces) == 12


def test_a_cube_shows_its_outer_side_however_it_was_wound():
    mixed = CUBE.faces.copy()
    mixed[::3] = mixed[::3, ::-1]
    for faces in (CUBE.faces, CUBE.faces[:, ::-1], mixed):
        assert outward_share(cleaned(Mesh(CUBE.vertices, faces))) == 1.0


def hill(noise: float) -> Mesh:
    x, y = np.meshgrid(np.linspace(-20, 20, 41), np.linspace(-20, 20, 41))
    vertices = np.stack([x.ravel(), y.ravel(), 5 * np.cos(x.ravel() / 12) * np.cos(y.ravel() / 15)], axis=1)
    vertices[:, 2] += np.random.default_rng(0).normal(0, noise, len(vertices)) if noise else 0.0
    return Mesh(vertices, grid_faces(vertices.reshape(41, 41, 3), np.inf))


def test_the_roughness_of_a_cube():
    assert roughness_deg(CUBE.vertices, CUBE.faces) == pytest.approx(90)  # of 18 edges six are diagonals
    assert roughness_deg(CUBE.vertices, CUBE.faces[:2]) == 0
    assert roughness_deg(CUBE.vertices, CUBE.faces[:1]) == 0


def test_noise_goes_and_the_shape_stays():
    clean, noisy = hill(0.0), hill(0.6)
    assert roughness_deg(noisy.vertices, noisy.faces) > 30
    even = evened(noisy)
    assert roughness_deg(even.vertices, even.faces) < ROUGH_DEG
    inside = (np.abs(clean.vertices[:, :2]) < 17).all(axis=1)
    off = np.linalg.norm(even.vertices - clean.vertices, axis=1)[inside]
    assert off.mean() < 0.6 * np.abs(noisy.vertices - clean.vertices)[inside, 2].mean()
    np.testing.assert_array_equal(evened(clean).vertices, clean.vertices)


def test_edges_of_three_triangles_are_counted():
    assert fork_edges(CUBE.faces) == 0
    assert fork_edges(np.concatenate([CUBE.faces, [[*CUBE.faces[0, :2], 7]]])) >= 1


def test_nothing_is_no_scan():
    with pytest.raises(BadInput, match="empty"):
        check_scan(Scan(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), name="empty"))
