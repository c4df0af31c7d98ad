"""The page of a tracked take."""

import numpy as np

import tracking_stage as stage
from mien.reports.tracking import Crop, depth_colors, faces_sheet, learning_chart, preview, take_report
from rgbd_study import played, tracked


def test_the_crop_s_camera_sees_what_is_cut_out():
    crop = Crop(100, 60, 80, 240)
    points = np.array([[10.0, -20.0, 700.0], [-30.0, 5.0, 640.0]])
    pixels = stage.CAMERA.project(points)
    image = np.zeros((240, 320, 3), np.uint8)
    u, v = np.round(pixels[0]).astype(int)
    image[v, u] = 255
    row, column = np.argwhere(crop.cut(image, smooth=False)[..., 0] == 255).mean(0)
    inside = crop.camera(stage.CAMERA).project(points)
    np.testing.assert_allclose(inside, ((pixels - [100, 60]) + 0.5) * 3 - 0.5)
    assert np.abs(inside[0] - [column, row]).max() <= 2.0


def test_depth_colours_tell_near_from_far_and_from_nothing():
    depth = np.array([[600.0, 690.0, 0.0]], np.float32)
    near, far, none = depth_colors(depth, 700.0)[0].astype(int)
    assert near.sum() > far.sum() > none.sum()


def test_preview_and_report_of_a_take():
    take, _ = played()
    picture = preview(take, tracked(), [2, 9], size=80)
    assert picture.shape == (80, 2 * (3 * 80 + 4) + 8, 3)
    html = take_report(take, tracked(), picture, notes=["Mind the gap."]).html()
    assert "12 frames at 30 a second from an RGB-D take; 12 tracked." in html
    assert "Mind the gap." in html
    chart = learning_chart(30.0, np.linspace(1, 0.5, 9), np.linspace(0.9, 0.1, 9), [(0.0, 0.1, "joy")])
    assert ">joy<" in chart
    assert "to the adaptive space" in chart


def test_faces_sheet_has_a_caption_a_face_and_a_scale():
    rig = stage.person()
    values = np.linspace(0, 2, len(rig.neutral.vertices))
    cells = [("rest", rig.neutral.vertices, None), ("far", rig.neutral.vertices, values)]
    sheet = faces_sheet(rig, cells, 2.0, columns=2)
    assert sheet.shape == (330, 2 * 260 + 3 + 84, 3)
    shaded, heat = sheet[30:, :260].astype(int), sheet[30:, 263:523].astype(int)
    assert np.abs(shaded - heat).mean() > 5
