"""How much of the sky a vertex sees."""

import numpy as np

from mien.mesh import Mesh, vertex_normals
from mien.pictures import ambient_occlusion
from mien.pictures.occlusion import sky_directions
from round_things import sphere


def test_sky_by_hand():
    """A sphere is open everywhere; inside a box nothing is; on a floor at the foot of a high wall half the sky is."""
    directions = sky_directions(500)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1)
    np.testing.assert_allclose(directions.mean(0), 0, atol=5e-3)
    ball = sphere(50, 16)
    np.testing.assert_allclose(ambient_occlusion(ball), 1)
    inside = Mesh(ball.vertices, ball.faces[:, ::-1].copy())
    np.testing.assert_allclose(ambient_occlusion(inside), 0, atol=1e-3)
    wide = 300.0
    corners = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0, 2], [-wide, -1, -0.5], [wide, -1, -0.5], [0, wide, -0.5]])
    scene = Mesh(corners, np.array([[0, 2, 1], [3, 4, 5]]))
    np.testing.assert_allclose(vertex_normals(scene.vertices, scene.faces)[0], [0, 1, 0])
    np.testing.assert_allclose(ambient_occlusion(scene, rays=2000)[:2], 0.5, atol=0.03)
    np.testing.assert_allclose(ambient_occlusion(scene, rays=200, reach=0.4)[:2], 1)
