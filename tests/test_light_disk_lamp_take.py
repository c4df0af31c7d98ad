import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import light_scene
from command import mien
from mien.errors import BadInput
from mien.light.disk.lamp_take import read_lamp_take
from mien.light.disk.light_scan import read_light_scan
from mien.light.normals import PointLamp
from mien.light.triangulate import pixel_rays

FACE = Path(__file__).resolve().parents[2] / "shared" / "data" / "near_light"
PLACES = ((-150, 0), (150, 0), (0, -150), (0, 150), (110, 110))
ROOM = 0.02


@pytest.fixture
def folder(tmp_path):
    """A ball under five near lamps, light of the room on it, 16 bits, linear."""
    left = light_scene.rig().cameras[0]
    depth, normals = light_scene.ball_depth(left)
    points, normals = np.nan_to_num(pixel_rays(left.camera) * depth[..., None]), np.nan_to_num(normals)
    facing = normals[..., 2] < -0.45
    lights = []
    for number, (x, y) in enumerate(PLACES):
        seen = np.clip((PointLamp((x, y, 250.0), 3e4).light(points) * normals).sum(-1), 0, None) * facing
        save(tmp_path / f"{number}.png", seen + ROOM)
        lights.append({"image": f"{number}.png", "position": [x, y, 250], "intensity": 3e4})
    save(tmp_path / "ambient.png", np.full(depth.shape, ROOM))
    save(tmp_path / "mask.png", facing.astype(float))
    camera = left.camera
    K = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (tmp_path / "lights.json").write_text(json.dumps({"lights": lights, "K": K}))
    return tmp_path


def save(path, values):
    Image.fromarray((65535 * np.clip(values, 0, 1)).astype(np.uint16)).save(path)


def test_a_ball_under_lamps_becomes_a_scan(folder, capsys):
    mien("decode", folder, lamps=True, gamma=1.0, output=folder / "s.exr")
    assert "5 lamps" in capsys.readouterr().out
    scan = read_light_scan(folder / "s.exr")
    _, normals = light_scene.ball_depth(light_scene.rig().cameras[0])
    known = np.isfinite(scan.normals[..., 0])
    assert known.sum() > 3000
    assert np.degrees(np.arccos(np.clip(np.median((scan.normals * normals).sum(-1)[known]), -1, 1))) < 5


def test_each_fault_is_one_clear_line(folder):
    save(folder / "3.png", np.zeros((200, 160)))
    with pytest.raises(BadInput, match=r"3\.png: black"):
        read_lamp_take(folder, 1.0)
    save(folder / "3.png", np.ones((100, 160)))
    with pytest.raises(BadInput, match=r"3\.png: 160 x 100"):
        read_lamp_take(folder, 1.0)
    (folder / "3.png").unlink()
    with pytest.raises(BadInput, match=r"3\.png"):
        read_lamp_take(folder, 1.0)
    told = json.loads((folder / "lights.json").read_text())
    (folder / "lights.json").write_text(json.dumps({**told, "lights": told["lights"][:2]}))
    with pytest.raises(BadInput, match="2 lamps; normals need 3"):
        read_lamp_take(folder, 1.0)


@pytest.mark.data
@pytest.mark.skipif(not FACE.is_dir(), reason="no recording under near lamps beside the checkout")
def test_a_real_recording_is_read():
    take = read_lamp_take(FACE)
    assert len(take.lamps) == 7
    assert take.mask.mean() > 0.2
    assert np.median(take.images.max(axis=0)[take.mask]) > 0.1
