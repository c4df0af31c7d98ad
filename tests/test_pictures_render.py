"""Pictures of meshes: colours by hand where light is off, laws of light, smooth subdivision, colour maps."""

from dataclasses import replace

import numpy as np
import pytest

from lit_things import CAMERA, FACING, FLAT, ball, square
from mien.errors import BadInput
from mien.mesh import Mesh
from mien.pictures import Look, Renderer, colors_of, frontal_camera, render
from mien.transforms import Transform, rotation_from_vector


def test_texture_is_the_right_way_up():
    """Red, green / blue, white: the picture's first row is v = 1."""
    texture = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], dtype=np.uint8)
    texture = texture.repeat(8, 0).repeat(8, 1)
    uv = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    by_vertex = render(square(uv=uv), CAMERA, FACING, texture=texture)
    order = np.array([2, 0, 3, 1])
    by_corner = square(uv=uv[order], uv_faces=np.argsort(order)[square().faces])
    np.testing.assert_array_equal(render(by_corner, CAMERA, FACING, texture=texture), by_vertex)
    upper_left, upper_right, lower_left, lower_right = (by_vertex[v, u].astype(int) for v in (10, 21) for u in (10, 21))
    assert upper_left[0] > 3 * upper_left[1:].max()
    assert upper_right[1] > 3 * upper_right[[0, 2]].max()
    assert lower_left[2] > 3 * lower_left[:2].max()
    assert lower_right.min() > 150
    look = Look(softness=0.0, occlusion=0)
    rough = render(by_corner, CAMERA, FACING, look, texture=texture)
    finer = render(by_corner, CAMERA, FACING, replace(look, refine=2), texture=texture)
    for v in (11, 20):
        for u in (11, 20):
            np.testing.assert_allclose(finer[v, u].astype(int), rough[v, u], atol=3)


def test_turned_mesh_before_a_turned_camera_looks_the_same():
    mesh = ball()
    values = mesh.vertices[:, 0].copy()
    camera, T_camera_face = frontal_camera(mesh, 64, yaw=0.3)
    turn = Transform(rotation_from_vector(np.array([0.4, -1.0, 0.7])), np.array([100.0, -20, 5]))
    moved = mesh.with_vertices(turn.apply(mesh.vertices))
    for more in ({}, {"values": values}):
        look = Look(limits=(-50.0, 50.0), occlusion=0)
        a = render(mesh, camera, T_camera_face, look, **more).astype(int)
        b = render(moved, camera, T_camera_face @ turn.inverse(), look, **more)
        assert np.abs(a - b).max() <= 2


def test_ambient_occlusion_darkens_what_is_shut_in():
    bowl = ball()
    bowl = Mesh(bowl.vertices, bowl.faces[(bowl.vertices[bowl.faces][:, :, 2] < 10).all(1)][:, ::-1].copy())
    camera, T = frontal_camera(bowl, 48)
    open_bowl = render(bowl, camera, T, Look(occlusion=0, softness=0.0)).astype(int)
    shut = render(bowl, camera, T, Look(softness=0.0)).astype(int)
    assert shut[24, 24].mean() < open_bowl[24, 24].mean() - 15
    given = Renderer(bowl, Look(softness=0.0)).draw(camera, T, open_sky=np.ones(len(bowl.vertices)))
    np.testing.assert_array_equal(given, open_bowl)


def test_alpha_cuts_the_face_out():
    look = Look(alpha=True)
    cut, whole = render(square(), CAMERA, FACING, look), render(square(), CAMERA, FACING)
    assert cut.shape == (32, 32, 4)
    assert cut[16, 16, 3] == 255
    assert cut[0, 0].tolist() == [0, 0, 0, 0]
    np.testing.assert_array_equal(cut[16, 16, :3], whole[16, 16])
    edge = cut[..., 3][(cut[..., 3] > 0) & (cut[..., 3] < 255)]
    assert set(edge.tolist()) <= {64, 127, 128, 191}


def test_nothing_in_sight_is_background():
    away = Transform(FACING.rotation, np.array([0.0, 0.0, -200.0]))
    image = render(square(), CAMERA, away)
    look = Look()
    np.testing.assert_allclose(image[16, 16], 255 * np.array(look.background[0]), atol=2)
    np.testing.assert_allclose(image[0, 0], 255 * np.array(look.background[1]), atol=2)
    assert (render(square(), CAMERA, away, FLAT, values=np.ones(4))[16, 16] == image[16, 16]).all()


def test_either_winding_is_drawn_alike():
    mesh = ball()
    inverted = Mesh(mesh.vertices, mesh.faces[:, ::-1].copy())
    camera, T = frontal_camera(mesh, 48)
    look = Look(occlusion=0)
    assert np.abs(render(mesh, camera, T, look).astype(int) - render(inverted, camera, T, look)).mean() < 1


def test_vertex_colours_show():
    image = render(square(colors=np.tile([0.9, 0.1, 0.1], (4, 1))), CAMERA, FACING)
    assert image[16, 16, 0] > 2.5 * image[16, 16, 1:].max()


def test_bad_input_is_told():
    with pytest.raises(BadInput, match="texture coordinates"):
        render(square(), CAMERA, FACING, texture=np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(BadInput, match="none of that name; choose from heat, diverging"):
        colors_of(np.zeros(1), (0.0, 1.0), "jet")
    with pytest.raises(BadInput, match=r"limits 1\.\.1"):
        colors_of(np.zeros(1), (1.0, 1.0))
