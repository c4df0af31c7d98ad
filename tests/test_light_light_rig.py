import json
from dataclasses import replace

import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.light_rig import brown_distortion, read_rig, write_rig


def test_a_calibration_comes_back(tmp_path):
    rig = replace(light_scene.rig(), gamma=2.2)
    write_rig(tmp_path / "c.json", rig)
    back = read_rig(tmp_path / "c.json")
    assert (back.gamma, back.R_rig_lamps) == (2.2, rig.R_rig_lamps)
    assert [view.camera for view in back.cameras] == [view.camera for view in rig.cameras]
    np.testing.assert_allclose(back.camera("right").T_view_rig.rotation, rig.cameras[1].T_view_rig.rotation)
    with pytest.raises(BadInput, match="it has left, right"):
        back.camera("top")


def test_a_lens_is_undone_and_pictures_straightened():
    view = replace(light_scene.view("left", 0.0), distortion=(-0.3, 0.2, 0.001, -0.002, 0.01))
    pixels = np.random.default_rng(0).uniform(0, 150, size=(50, 2))
    np.testing.assert_allclose(view.distorted(view.undistorted(pixels)), pixels, atol=1e-6)
    x = np.tile(np.arange(160.0), (200, 1))
    straight = view.straightened(x)
    np.testing.assert_allclose(straight[100, 40], view.distorted(np.array([40.0, 100.0]))[0], atol=1e-3)
    assert brown_distortion(np.array([[0.1, 0.0]]), (1.0, 0, 0, 0, 0))[0, 0] == pytest.approx(0.1 * 1.01)


def test_what_is_no_calibration_is_refused(tmp_path):
    write_rig(tmp_path / "c.json", light_scene.rig())
    good = json.loads((tmp_path / "c.json").read_text())
    faults = [{}, [], {"cameras": []}, good | {"gamma": 0.0}, good | {"cameras": [{"name": "a"}]}]
    broken = json.loads(json.dumps(good))
    broken["cameras"][0]["intrinsic_matrix"][0] = float("nan")
    for fault in [*faults, broken]:
        (tmp_path / "c.json").write_text(json.dumps(fault))
        with pytest.raises(BadInput, match=r"c\.json"):
            read_rig(tmp_path / "c.json")
