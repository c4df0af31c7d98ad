from pathlib import Path

import numpy as np

from mien.camera import Camera
from mien.cli.live_page import LivePage
from mien.depth import RGBDFrame
from mien.faces import load_face
from mien.rgbd import RgbdTake, read_rgbd


def test_a_recording_is_a_take_that_is_read_again(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    picture = np.full((48, 64, 3), 90, np.uint8)
    frames = [RGBDFrame(picture, None, 5 + i / 30) for i in range(4)]
    take = RgbdTake("camera", Camera(60.0, 60.0, 31.5, 23.5, 64, 48), 30.0, 4, False, lambda: iter(frames))
    page = LivePage(take, load_face().rig)
    page.feed._record(b"", {})
    list(page.take)
    told = page.feed._record(b"", {}).body.decode()
    [folder] = Path().glob("take-*")
    assert str(folder) in told
    assert str(folder) in capsys.readouterr().err
    again = list(read_rgbd(folder))
    assert len(again) == 4
    assert again[0].time == 0.0
