"""Pictures of meshes: colours by hand where light is off, laws of light, smooth subdivision, colour maps."""

from dataclasses import replace

import numpy as np
import pytest

from mien.camera import Camera
from mien.errors import BadInput
from mien.mesh import Mesh, loop_refinement
from mien.pictures import Look, Renderer, colors_of, frontal_camera, render
from mien.pictures.color import to_linear, to_srgb
from mien.pictures.colormap import MAPS, NOTHING, own_limits, table
from mien.pictures.eyes import eyeballs
from mien.transforms import Transform, rotation_from_vector

FLAT = Look(supersample=1, occlusion=0, softness=0.0, value_shading=0.0)
"""A heat map's colours and nothing else."""
CAMERA = Camera(100.0, 100.0, 15.5, 15.5, 32, 32)
FACING = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 200.0]))


def square(half: float = 20.0, z: float = 0.0, **more) -> Mesh:
    corners = np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]), **more)


def ball(radius: float = 50.0, centre=(0.0, 0.0, 0.0), rounds: int = 4) -> Mesh:
    """An octahedron, split and pushed out to the sphere."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(rounds):
        finer = loop_refinement(faces, len(vertices))
        vertices, faces = finer.between @ vertices, finer.faces
        vertices = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    return Mesh(vertices * radius + centre, faces)


def test_heat_map_colours_at_the_limits():
    values = np.array([0.0, 2.0, 2.0, 0.0])  # runs from left to right
    image = render(square(), CAMERA, FACING, replace(FLAT, limits=(0.5, 1.5)), values=values)
    low, high = (np.rint(255 * table("heat")[level]).astype(int) for level in (0, -2))
    np.testing.assert_allclose(image[16, 7], low, atol=1)
    np.testing.assert_allclose(image[16, 24], high, atol=1)
    middle = (image[16, 15].astype(float) + image[16, 16]) / 2
    np.testing.assert_allclose(middle, 255 * colors_of(np.array([1.0]), (0.5, 1.5))[0], atol=4)


def test_values_that_are_nan_are_grey_and_their_own_range_is_the_default():
    values = np.array([1.0, 3.0, 3.0, np.nan])
    image = render(square(), CAMERA, FACING, FLAT, values=values)
    np.testing.assert_allclose(image[8, 8], 255 * np.array(NOTHING), atol=1)  # upper left
    right = colors_of(np.array([1 + 2 * (17 + 20) / 40]), (1.0, 3.0))[0]  # x = 17 mm of -20..20
    np.testing.assert_allclose(image[24, 24], 255 * right, atol=1)
    assert own_limits(values) == (1.0, 3.0)
    assert own_limits(np.full(3, 2.0)) == (2.0, 3.0)
    assert own_limits(np.full(3, np.nan)) == (0.0, 1.0)


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


def test_eyes_are_known_by_their_shape():
    head, eye = ball(100.0), ball(14.0, (30.0, 0.0, 90.0), rounds=3)
    tooth = square(5.0, 120.0)
    parts = [head, eye, tooth]
    starts = np.cumsum([0, *(len(p.vertices) for p in parts)])
    faces = np.vstack([p.faces + s for p, s in zip(parts, starts, strict=False)])
    mesh = Mesh(np.vstack([p.vertices for p in parts]), faces)
    found = eyeballs(mesh)
    np.testing.assert_array_equal(np.flatnonzero(found), np.arange(starts[1], starts[2]))
    long = mesh.with_vertices(np.where(found[:, None], mesh.vertices * (1, 1.3, 1), mesh.vertices))
    assert not eyeballs(long).any()


@pytest.mark.parametrize("name", MAPS)
def test_colour_maps_are_even_to_the_eye(name):
    """Lightness (CIE L*) runs steadily; a diverging map is as light on both sides."""
    colors = table(name)[:-1]
    assert colors.min() >= 0
    assert colors.max() <= 1
    Y = to_linear(colors) @ [0.2126, 0.7152, 0.0722]
    L = 116 * np.cbrt(Y) - 16
    half = len(L) if name == "heat" else len(L) // 2
    steps = np.diff(L[:half:16])
    assert (steps > 0).all()
    assert steps.max() < 2.2 * steps.min()
    if name == "diverging":
        np.testing.assert_allclose(L, L[::-1], atol=4)


def test_srgb_round_trip_and_known_values():
    levels = np.linspace(0, 1, 256)
    np.testing.assert_allclose(to_srgb(to_linear(levels)), levels, atol=1e-12)
    np.testing.assert_allclose(to_linear(np.array([0.5])), [0.21404114], atol=1e-8)


def test_bad_input_is_told():
    with pytest.raises(BadInput, match="texture coordinates"):
        render(square(), CAMERA, FACING, texture=np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(BadInput, match="none of that name; choose from heat, diverging"):
        colors_of(np.zeros(1), (0.0, 1.0), "jet")
    with pytest.raises(BadInput, match=r"limits 1\.\.1"):
        colors_of(np.zeros(1), (1.0, 1.0))
