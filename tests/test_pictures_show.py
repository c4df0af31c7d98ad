"""Performances, rigs and scans in pictures; the command that draws them."""

import time
from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.mesh import Mesh, Scan
from mien.pictures.render import Look
from mien.pictures.show import (
    Shot,
    film_frames,
    head_motion,
    heat_limits,
    performance_distance,
    performance_frames,
    performance_view,
    rig_look,
    scan_picture,
    shapes_sheet,
    side_by_side,
    surface_distance,
    turntable,
)
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector
from shown_things import ball, brows_and_cheeks, nodding

QUICK = Look(supersample=1, occlusion=0, softness=0.0)


@pytest.fixture
def rig() -> Rig:
    return brows_and_cheeks()


@pytest.fixture
def performance(rig) -> Performance:
    return nodding(rig)


def test_head_motion_is_about_the_mean_pose(performance):
    motion = head_motion(performance)
    np.testing.assert_allclose(motion.rotation[4], np.eye(3), atol=1e-9)  # half way through its turn
    np.testing.assert_allclose(motion.rotation[0], rotation_from_vector(np.array([0, 0.5, 0.0])), atol=1e-9)
    elsewhere = Transform(rotation_from_vector(np.array([0.3, 1.0, -2.0])), np.array([5.0, 6, 7]))
    shifted = replace(performance, T_world_face=elsewhere @ performance.T_world_face)
    np.testing.assert_allclose(head_motion(shifted).rotation, motion.rotation, atol=1e-9)


def test_every_frame_is_in_the_picture(performance):
    view, T_camera_face = performance_view(performance, Shot(size=100))
    for t in range(len(performance)):
        pixels = view.camera.project(T_camera_face[t].apply(performance.rig.vertices(performance.weights[t])))
        assert pixels.min() > 0
        assert pixels.max() < 99
    _, still = performance_view(performance, Shot(size=100, still_head=True))
    np.testing.assert_allclose(still.rotation, np.tile(still.rotation[0], (9, 1, 1)))


def test_frames_come_in_order_with_progress(performance):
    seen = []

    class Watch:
        def update(self, stage, done, total):
            seen.append((done, total))

    images = list(performance_frames(performance, [8, 0, 4], Shot(size=64, still_head=True), QUICK, progress=Watch()))
    assert seen == [(1, 3), (2, 3), (3, 3)]
    np.testing.assert_array_equal(images[0], images[1])  # weights are 0 at both ends
    assert (images[2] != images[1]).any()


def test_heat_maps_share_one_scale(performance):
    other = replace(performance, weights=performance.weights * 0.5)
    values = performance_distance(performance, other)
    np.testing.assert_allclose(values(0), 0, atol=1e-9)
    np.testing.assert_allclose(values(4).max(), 15)
    images = list(performance_frames(performance, [0, 4], Shot(size=64, still_head=True), values=values))
    assert images[0].shape[1] > 64  # the scale
    np.testing.assert_array_equal(images[0][:, 64:], images[1][:, 64:])
    moved = replace(performance, T_world_face=Transform(np.eye(3), np.array([3.0, 4, 0])) @ performance.T_world_face)
    np.testing.assert_allclose(performance_distance(performance, moved)(2), 5)
    np.testing.assert_allclose(performance_distance(performance, moved, still=True)(2), 0, atol=1e-9)


def test_surface_distance_by_hand():
    mesh = ball()
    grown = mesh.with_vertices(mesh.vertices * 1.1)
    np.testing.assert_allclose(surface_distance(mesh, grown), 8)
    order = np.random.default_rng(0).permutation(len(mesh.faces))
    other = Mesh(grown.vertices, grown.faces[order])
    found = surface_distance(mesh, other)  # another topology: the nearest point of the surface
    assert (found <= 8).all()
    assert (found > 7).all()


def test_heat_limits_are_round():
    assert heat_limits([np.full(50, 0.013), np.full(50, 1.7)]) == (0.0, 2.0)
    assert heat_limits([np.array([5.0])]) == (0.0, 5.0)
    assert heat_limits([np.zeros(3)]) == (0.0, 1.0)
    assert heat_limits([np.array([np.nan, 0.3])]) == (0.0, 0.5)
    assert heat_limits([], 0.7) == (0.0, 0.7)


def test_films_keep_to_their_rate(performance):
    assert film_frames(performance, 30.0) == (range(0, 9, 2), 30.0)
    assert film_frames(performance, 60.0) == (range(0, 9, 1), 60.0)
    assert film_frames(performance, 25.0) == (range(0, 9, 3), 20.0)


def test_shapes_sheet_draws_each_shape(rig):
    sheet = shapes_sheet(rig, Shot(size=64), look=QUICK)
    assert sheet.shape == (132, 132, 3)
    cells = [sheet[:50, :64], sheet[:50, 68:], sheet[68:118, :64]]
    assert all((a != b).any() for a, b in ((cells[0], cells[1]), (cells[0], cells[2]), (cells[1], cells[2])))
    assert shapes_sheet(rig, Shot(size=64), count=1, look=QUICK).shape == (64, 132, 3)


def test_mouth_close_is_drawn_on_the_open_jaw(rig):
    closing = Rig(rig.neutral, np.stack([rig.deltas[0], -rig.deltas[0]]), ("jawOpen", "mouthClose"))
    sheet = shapes_sheet(closing, Shot(size=64), look=QUICK)
    np.testing.assert_array_equal(sheet[68:110, :64], sheet[:42, :64])  # above its name: as the neutral


def test_turntable_comes_back(rig):
    scan = Scan(rig.neutral.with_vertices(rig.vertices(np.array([0.0, 1.0]))))
    frames = list(turntable(scan, Shot(size=48, fps=8.0), QUICK, seconds=1.0))
    assert len(frames) == 8
    np.testing.assert_array_equal(frames[0], scan_picture(scan, Shot(size=48, fps=8.0), QUICK))
    assert np.abs(frames[0].astype(int) - frames[4]).max() <= 1
    assert (frames[0] != frames[2]).any()


def test_rig_look_makes_coarse_rigs_smooth():
    def rounds(n):
        return rig_look(Mesh(np.zeros((n, 3)), np.zeros((0, 3), int))).refine

    assert [rounds(n) for n in (500, 5_000, 50_000)] == [2, 1, 0]


def test_side_by_side_keeps_order_and_looks_no_further_than_it_must():
    taken = []

    def items():
        for i in range(1000):
            taken.append(i)
            yield i

    def work(i):
        time.sleep(0.002 * (i % 3 == 0))
        return i * i

    run = side_by_side(work, items())
    assert [next(run) for _ in range(20)] == [i * i for i in range(20)]
    assert len(taken) < 200
    run.close()


def test_errors_in_a_frame_come_out():
    def work(i):
        if i == 3:
            raise BadInput("three")
        return i

    with pytest.raises(BadInput, match="three"):
        list(side_by_side(work, range(10)))
