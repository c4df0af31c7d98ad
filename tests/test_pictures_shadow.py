"""Shadows."""

from dataclasses import replace

import numpy as np

from lit_things import ball, square
from mien.mesh import Mesh
from mien.pictures import Look, frontal_camera, render
from mien.pictures.color import to_linear


def test_light_comes_from_the_key_and_shadows_fall():
    """The key stands at the upper left: a ball is brighter there, and darkens a wall right below."""
    mesh = ball()
    camera, T = frontal_camera(mesh, 64)
    image = to_linear(render(mesh, camera, T) / 255).mean(2)
    assert image[20, 20] > 2 * image[44, 44]
    wall = square(400.0, -80.0)
    both = Mesh(np.vstack([mesh.vertices, wall.vertices]), np.vstack([mesh.faces, wall.faces + len(mesh.vertices)]))
    look = Look(occlusion=0)
    alone = to_linear(render(wall, camera, T, look) / 255).mean(2)
    behind = to_linear(render(both, camera, T, look) / 255).mean(2)
    bare = to_linear(render(both, camera, T, replace(look, softness=0.0)) / 255).mean(2)
    outside = np.hypot(*np.meshgrid(np.arange(64) - 31.5, np.arange(64) - 31.5)) > 30
    fallen = alone - behind
    assert fallen[outside].max() > 0.3 * alone.max()
    v, u = np.nonzero(outside & (fallen > 0.2 * alone.max()))
    assert v.mean() > 40
    assert u.mean() > 40
    np.testing.assert_allclose(bare[outside], alone[outside], atol=0.02)


def test_no_shadow_acne_on_a_coarse_ball():
    """Convex: no point shadows another, so shadows may change nothing, neither on slopes nor on big triangles."""
    for rounds in (2, 5):
        mesh = ball(80.0, rounds=rounds)
        camera, T = frontal_camera(mesh, 96)
        look = Look(occlusion=0)
        lit = render(mesh, camera, T, replace(look, softness=0.0)).astype(int)
        assert np.abs(render(mesh, camera, T, look) - lit).max() <= 2
