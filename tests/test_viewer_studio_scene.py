import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.mesh import Scan
from mien.viewer.scene_file import read_array, read_scene
from mien.viewer.studio_scene import Shown, eyes_of, mean_pose, pack_scene
from studio_things import nodding


def test_a_frame_is_weights_and_a_pose():
    performance = nodding(5)
    header, body = read_scene(pack_scene([Shown("perf", performance)]))
    motion = header["faces"][0]["motion"]
    np.testing.assert_allclose(read_array(body, motion["weights"]), performance.weights, atol=1e-7)
    assert read_array(body, motion["poses"]).shape == (5, 7)
    assert 4 * (motion["shapes"] + 7) <= 1000


def test_a_scan_is_a_face_without_shapes():
    header, _ = read_scene(pack_scene([Shown("scan", Scan(load_face().rig.neutral))]))
    assert header["faces"][0]["names"] == []
    assert "motion" not in header["faces"][0]


def test_eyes_are_known_on_the_bundled_face():
    eyes = eyes_of(load_face().rig.neutral)
    assert eyes[0][0] > 0 > eyes[1][0]
    assert 10 < eyes[0][3] < 20


def test_the_mean_pose_is_what_the_motion_is_about():
    performance = nodding(5)
    place = mean_pose(performance).translation
    np.testing.assert_allclose(place, np.median(performance.T_world_face.translation, axis=0), atol=1e-6)


def test_what_makes_no_page_is_told():
    take = Markers(np.zeros((2, 6, 3)), tuple("abcdef"), 30.0)
    with pytest.raises(BadInput, match="nothing to show a face with"):
        pack_scene([Shown("take", take)])
    rig = load_face().rig
    with pytest.raises(BadInput, match="too many"):
        pack_scene([Shown("rig", rig)] * 5)
    with pytest.raises(BadInput, match="over a performance"):
        pack_scene([Shown("rig", rig), Shown("take", take)])
