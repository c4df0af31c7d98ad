import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import light_scene
from mien.camera import Camera
from mien.errors import BadInput
from mien.light.disk.light_take import read_grey
from mien.light.near_light import NearLightConfig, near_light_surface, read_lamps
from mien.light.normals import PhotometricStereoConfig, PointLamp
from mien.light.triangulate import pixel_rays

FACE = Path(__file__).resolve().parents[2] / "shared" / "data" / "near_light"
LEFT = light_scene.rig().cameras[0]


def test_a_ball_under_near_lamps_comes_out_round_and_at_its_distance():
    depth, normals = light_scene.ball_depth(LEFT)
    rays = pixel_rays(LEFT.camera)
    with np.errstate(invalid="ignore"):
        mask = (normals * rays).sum(-1) / np.linalg.norm(rays, axis=-1) < -0.45
    points = np.nan_to_num(rays * depth[..., None])
    lamps = [PointLamp((x, y, 250.0), 3e4) for x, y in ((-150, 0), (150, 0), (0, -150), (0, 150), (110, 110))]
    images = np.stack([0.5 * np.clip((lamp.light(points) * np.nan_to_num(normals)).sum(-1), 0, None) for lamp in lamps])
    found = near_light_surface(
        images, lamps, LEFT.camera, mask, NearLightConfig(photometric=PhotometricStereoConfig(shadow=1e-4))
    )
    assert found.mean_mm == pytest.approx(np.nanmean(depth[mask]), rel=0.08)
    told = NearLightConfig(start_mm=float(np.nanmean(depth[mask])), photometric=PhotometricStereoConfig(shadow=1e-4))
    found = near_light_surface(images, lamps, LEFT.camera, mask, told)
    assert np.nanmean(np.abs(found.z - depth)[mask]) < 0.5
    assert found.residual < 0.01
    halved = near_light_surface(images, lamps, LEFT.camera, mask, replace(told, smallest=800))
    assert np.nanmax(np.abs(halved.z - found.z)) < 0.3
    with pytest.raises(BadInput, match="empty"):
        near_light_surface(images, lamps, LEFT.camera, np.zeros_like(mask))


def test_lists_of_lamps_are_read_or_refused(tmp_path):
    path = tmp_path / "lights.json"
    light = {"image": "a.png", "position": [1, 2, 3], "intensity_rgb": [1, 2, 6], "direction": [0, 0, 1], "mu": 1}
    path.write_text(json.dumps({"lights": [light], "K": np.eye(3).tolist()}))
    lamps, names, K = read_lamps(path)
    assert (lamps[0].intensity, lamps[0].mu, names, K.shape) == (3.0, 1.0, ["a.png"], (3, 3))
    assert read_lamps(path, 2)[0][0].intensity == 6
    for text in ("{}", "no", json.dumps({"lights": [light], "K": [1, 2]})):
        path.write_text(text)
        with pytest.raises(BadInput, match=r"lights\.json"):
            read_lamps(path)


@pytest.mark.data
@pytest.mark.skipif(not FACE.is_dir(), reason="no recording under near lamps beside the checkout")
def test_a_real_face_under_seven_lamps_looks_at_the_camera():
    lamps, names, K = read_lamps(FACE / "lights.json")
    step = 3
    room = read_grey(FACE / "ambient.png", 2.2)
    images = np.stack([np.clip(read_grey(FACE / name, 2.2) - room, 0, None)[::step, ::step] for name in names])
    mask = (np.array(Image.open(FACE / "mask.png").convert("L")) > 127)[::step, ::step]
    camera = Camera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], room.shape[1], room.shape[0]).scaled(1 / step)
    camera = Camera(camera.fx, camera.fy, camera.cx, camera.cy, images.shape[2], images.shape[1])
    found = near_light_surface(
        images, lamps, camera, mask, NearLightConfig(photometric=PhotometricStereoConfig(shadow=0.0008))
    )
    known = found.light.known & mask
    assert 600 < found.mean_mm < 1000
    assert np.median(found.light.normals[known][:, 2]) < -0.6
    nose, cheek = found.z[172:200, 120:140], found.z[172:200, 52:72]
    assert np.nanmedian(cheek) - np.nanmedian(nose) > 8
