"""`mien demo blendshapes`: its figures and its report, on a small rig; and without what it needs."""

import base64
import gzip
from dataclasses import replace

import numpy as np
import pytest

from blendshape_rig import built_rig, true_landmarks
from mien.blendshapes.build.rig_files import write_textured_rig
from mien.blendshapes.correspond import landmarks as landmark_room
from mien.cli import demo_blendshapes
from mien.cli.demo_blendshapes import CAPTIONS, arkit_part, draw_figures, playing, report
from mien.cli.main import main
from mien.experiments import blendshapes_figures, blendshapes_ways
from mien.experiments.blendshapes_figures import Driven
from mien.faces import ARKIT_NAMES
from mien.landmarks.model_file import VARIABLE
from mien.progress import SILENT
from mien.rig import Performance
from mien.transforms import Transform
from mien.viewer.scene_file import read_scene
from worn_face import under_headset


@pytest.fixture
def session(monkeypatch):
    """The small rig's captures under the names of the stage's."""
    built = built_rig()
    first, second = built.shapes
    names = ("smile", "jawOpen", "mouthLeft", "frown")
    shapes = tuple(replace(one, name=n) for one, n in zip((second, first, first, second), names, strict=True))
    rig = built.textured.rig
    named = replace(rig, names=("smile", *rig.names[1:-1], "frown"))
    built = replace(built, shapes=shapes, textured=replace(built.textured, rig=named))
    weights = np.zeros((demo_blendshapes.CLIP_FRAMES, len(rig.names)))
    clip = Driven(
        [np.zeros((48, 64, 3), np.uint8)] * len(weights),
        Performance(named, weights, Transform.identity(len(weights)), 10.0, np.ones(len(weights), bool)),
    )
    monkeypatch.setattr(blendshapes_figures, "PIXELS", 48)
    monkeypatch.setattr(blendshapes_figures, "RAYS", 0)
    monkeypatch.setattr(landmark_room, "landmarks_on_map", true_landmarks)
    monkeypatch.setattr(blendshapes_ways, "template_fit", lambda *_: built.neutral.artist.mesh.vertices)
    return built, {"own": clip, "foreign": clip}


@pytest.fixture
def worn():
    """The small rig under a headset."""
    return under_headset(built_rig().textured.rig)


def test_every_figure_is_drawn_and_stands_in_the_report(session, worn, tmp_path):
    built, clips = session
    figures = draw_figures(built, clips, None, worn)
    assert set(figures) == set(CAPTIONS)
    assert all(np.ptp(picture) > 50 for picture in figures.values())
    row = {"mean": 0.5, "median": 0.4, "p95": 1.0, "drift median": 0.5, "drift p95": 2.0, "side mean": 0.4}
    report(tmp_path, {"smile": row}, figures, clips, built, worn)
    page = (tmp_path / "report.html").read_text()
    assert all(f"Figure {number}" in page for number in CAPTIONS)
    assert "0.50 mm" in page
    assert "of a mean face" in page
    assert "blind" in page
    assert (tmp_path / "figure_9.png").is_file()


def test_both_clips_are_filmed_and_play_in_one_page(session, tmp_path, monkeypatch):
    built, clips = session
    monkeypatch.setattr(demo_blendshapes, "FILM_PIXELS", 48)
    rig, zeros = clips["own"].performance.rig, np.zeros((2, len(clips["own"].performance.rig.names)))
    two = Performance(rig, zeros, Transform.identity(2), 10.0, np.ones(2, bool))
    short = {name: replace(clip, performance=two) for name, clip in clips.items()}
    write_textured_rig(tmp_path / "me.glb", built.textured)
    playing(tmp_path, short, built.textured, SILENT)
    assert (tmp_path / "own.mp4").stat().st_size > 500
    assert (tmp_path / "foreign.mp4").is_file()
    page = (tmp_path / "index.html").read_text()
    header, _ = read_scene(gzip.decompress(base64.b64decode(page.split('MIEN_SCENE = "')[1].split('"')[0])))
    assert [len(face["captures"]) for face in header["faces"]] == [2, 2]


def test_drivers_play_the_arkit_shapes_alone():
    assert arkit_part(built_rig().textured.rig).names == ARKIT_NAMES


def test_the_demo_without_the_landmark_model_is_one_line(tmp_path, monkeypatch, capsys):
    pytest.importorskip("mediapipe")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "nothing.task"))
    with pytest.raises(SystemExit) as stop:
        main(["demo", "blendshapes", "-o", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
