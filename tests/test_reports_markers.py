import numpy as np

from mien.clip import Markers
from mien.pictures import frontal_camera
from mien.reports.markers import telling_frames, with_dots, worst_markers
from studio_things import nodding


def test_the_worst_markers_come_first_and_unseen_ones_not_at_all():
    positions = np.zeros((4, 7, 3))
    positions[:2, 5] = np.nan
    residuals = np.tile(np.arange(7.0), (4, 1))
    residuals[:, 6] = np.nan
    worst = worst_markers(residuals, Markers(positions, tuple("abcdefg"), 30.0))
    assert [row[0] for row in worst] == ["f", "e", "d", "c", "b"]
    assert worst[0] == ("f", 5.0, "50%")


def test_telling_frames_differ_and_stand_in_order():
    frames = telling_frames(nodding(31), 4)
    assert frames == sorted(set(frames))
    assert len(frames) == 4


def test_a_dot_stands_where_its_point_is_seen():
    mesh = nodding(3).rig.neutral
    view = frontal_camera(mesh, (100, 120))
    point = mesh.vertices[[np.argmax(mesh.vertices[:, 2])]]
    black = np.zeros((120, 100, 3), np.uint8)
    drawn = with_dots(black, view, point)
    u, v = np.round(view.camera.project(view.T_camera_face.apply(point))[0]).astype(int)
    assert drawn[v, u].min() > 200
    assert (drawn.sum(axis=2) > 0).sum() < 40
    np.testing.assert_array_equal(with_dots(black, view, np.zeros((0, 3))), black)
