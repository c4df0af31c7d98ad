"""The figures of textured blendshapes."""

import numpy as np
import pytest

from blendshape_rig import built_rig, true_landmarks
from mien.blendshapes.align import AlignedCapture
from mien.experiments import blendshapes_figures as draw
from mien.rig import Performance
from mien.transforms import Transform


@pytest.fixture(scope="module", autouse=True)
def small():
    patch = pytest.MonkeyPatch()
    patch.setattr(draw, "PIXELS", 48)
    patch.setattr(draw, "RAYS", 0)
    yield
    patch.undo()


def test_a_pose_has_its_own_shape_and_texture():
    textured = built_rig().textured
    rest, plain = draw.posed(textured, {})
    jaw, changed = draw.posed(textured, {"jawOpen": 1.0})
    np.testing.assert_allclose(rest, textured.rig.neutral.vertices)
    np.testing.assert_array_equal(plain, textured.rig.texture)
    np.testing.assert_allclose(jaw - rest, textured.rig.deltas[textured.rig.index("jawOpen")], atol=1e-9)
    assert (changed != plain).any()


@pytest.mark.parametrize("sheet", [draw.tracking_sheet, draw.shape_sheet])
def test_sheets_show_the_neutral_and_every_shape(sheet):
    picture = sheet(built_rig().textured.rig, ["jawOpen", "grin"])
    cells = [picture[:48, i * 52 : i * 52 + 40] for i in range(3)]
    assert np.abs(cells[0].astype(int) - cells[1]).max() > 30
    assert all(np.ptp(cell) > 50 for cell in cells)


def test_textured_poses_in_one_sheet():
    picture = draw.posed_sheet(built_rig().textured, {"rest": {}, "jaw": {"jawOpen": 1.0}}, 2)
    assert picture.shape == (48, 100, 3)
    assert np.ptp(picture) > 50


def test_landmarks_are_dots_on_the_maps():
    neutral = built_rig().neutral
    picture = draw.landmark_sheet({"": (neutral.map, neutral.landmarks)})
    green = (picture[..., 1].astype(int) > picture[..., 0] + 40).mean()
    assert green > 0.05


def test_warped_colours_look_like_the_neutral():
    built = built_rig()
    picture = draw.warp_sheet(built.neutral, [built.shapes[0]]).astype(int)
    neutral, source, warped = (picture[4:36, i * 52 + 4 : i * 52 + 44] for i in range(3))
    assert np.abs(warped - neutral).mean() < 0.7 * np.abs(source - neutral).mean()


def test_brows_are_cut_from_the_texture_and_a_slid_template_drifts():
    built = built_rig()
    neutral, shape = built.neutral, built.shapes[0]
    rows, columns = draw.brow_texels(neutral)
    assert 2 < rows.stop - rows.start < 100
    assert 5 < columns.stop - columns.start < 128
    aligned = AlignedCapture(shape.map, true_landmarks(shape.map), Transform.identity(), 0.0)
    slid = neutral.artist.mesh.vertices + np.array([6.0, 0.0, 0.0])
    picture = draw.drift_sheet(neutral, shape, aligned, slid).astype(int)
    height = (picture.shape[0] + 4) // 3
    first, ours, theirs = (picture[i * height + 2 : (i + 1) * height - 16] for i in range(3))
    assert np.abs(ours - first).mean() < np.abs(theirs - first).mean()


def test_the_driver_stands_over_the_driven_face():
    textured = built_rig().textured
    weights = np.zeros((2, len(textured.rig.names)))
    weights[1, textured.rig.index("jawOpen")] = 1.0
    performance = Performance(textured.rig, weights, Transform.identity(2), 10.0, np.ones(2, bool))
    seen = [np.full((60, 80, 3), 40 + 100 * i, np.uint8) for i in range(2)]
    picture = draw.puppet_sheet(draw.Driven(seen, performance), textured, [0, 1])
    assert (picture[:48, :48] == 40).all()
    assert (picture[:48, 52:100] == 140).all()
    assert np.abs(picture[52:, :48].astype(int) - picture[52:, 52:100]).max() > 30
    np.testing.assert_array_equal(draw.played_weights(performance, textured.rig, 1), weights[1])
