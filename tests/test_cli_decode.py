import shutil

import numpy as np
import pytest
from PIL import Image

from command import mien
from mien.errors import BadInput
from mien.experiments.light_stage import LightStageConfig, staged_capture
from mien.io.meshes import read_scan
from mien.light.disk.light_scan import read_light_scan
from mien.light.light_rig import write_rig
from mien.light.patterns import read_patterns, write_patterns
from mien.stage import SkinConfig, make_performer, make_skin

SMALL = LightStageConfig(size=(144, 192), projector=(512, 384))
LOOSE = {"decode__border_px": 1, "decode__window_px": 5.0, "triangulate__smallest_piece": 50}


@pytest.fixture(scope="module")
def take(tmp_path_factory):
    """Two captures, the second of which has its slots out of order."""
    folder = tmp_path_factory.mktemp("take")
    skin = make_skin(make_performer(4), SkinConfig(levels=1, eyes_and_teeth=False), 4)
    rest = np.zeros(len(skin.names))
    capture = staged_capture(skin, rest, rest, SMALL)
    write_patterns(folder / "patterns.json", capture.patterns)
    write_rig(folder / "calibration.json", capture.rig)
    for name, images in capture.images.items():
        (folder / name).mkdir()
        dark = np.random.default_rng(0).uniform(0, 0.01, size=images.shape)
        for number, image in enumerate(np.concatenate([images, dark])):
            Image.fromarray((65535 * image).astype(np.uint16)).save(folder / name / f"{number:03d}.png")
    return folder


def test_a_bad_capture_is_named_and_the_rest_decoded(take, tmp_path, capsys):
    mien("decode", take, output=tmp_path / "out", **LOOSE)
    told = capsys.readouterr().out
    assert "capture 1 left out" in told
    assert "1 of 2 captures" in told
    scan = read_light_scan(tmp_path / "out" / "capture_0000.exr")
    assert scan.known.sum() > 3000


def test_one_capture_becomes_a_mesh(take, tmp_path):
    for name in ("left", "right"):
        (tmp_path / "one" / name).mkdir(parents=True)
        for number in range(12):
            (tmp_path / "one" / name / f"{number:03d}.png").write_bytes(
                (take / name / f"{number:03d}.png").read_bytes()
            )
    shutil.copy(take / "patterns.json", tmp_path / "one")
    mien("decode", tmp_path / "one", output=tmp_path / "s.ply", calibration=take / "calibration.json", **LOOSE)
    assert len(read_scan(tmp_path / "s.ply").mesh.vertices) > 3000


def test_patterns_are_written(tmp_path, capsys):
    mien("decode", show="gray", projector="64x48", output=tmp_path / "p")
    assert len(list((tmp_path / "p").glob("*.png"))) == len(read_patterns(tmp_path / "p" / "patterns.json")) == 26
    assert "26 pictures" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "options", "line"),
    [
        ((), {}, "name a folder"),
        (("no",), {}, "no"),
        ((), {"show": "gray", "calibration": "c.json"}, "calibration"),
        ((".",), {"board": "9x7"}, "9x7x75"),
        ((".",), {"projector": "64x48"}, "projector"),
    ],
)
def test_bad_words_are_one_line(words, options, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=line):
        mien("decode", *words, **options)
