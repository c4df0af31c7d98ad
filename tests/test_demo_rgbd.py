"""`mien demo rgbd` and the report of a tracked take: the parts, on a small stage where everything is known."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import tracking_stage as stage
from mien.cli import demo_rgbd
from mien.cli.main import main
from mien.cli.personalize import beside
from mien.errors import BadInput
from mien.experiments.tracking_ablation import FULL, Remembered, compare, left_out
from mien.io.gltf import read_performance, write_rig
from mien.io.rgbd import read_rgbd, write_rgbd
from mien.io.rgbd.live import Replay, live_frames
from mien.landmarks.model_file import VARIABLE
from mien.reports.tracking import Crop, depth_colors, faces_sheet, learning_chart, preview, take_report
from mien.rig import Rig
from mien.rig.retarget import CORRECTIVE
from mien.stage.script.repeated_script import REPEATED, repeated_script
from mien.tracking.pipeline import TrackTakeConfig, track_take
from mien.tracking.terms.fit_config import BlendshapeFitConfig

FRAMES = 12


@cache
def played():
    rig = stage.person()
    take, landmarker = stage.acted(rig, stage.talk(rig, FRAMES), stage.sway(FRAMES), noise=0.5)
    return take, Remembered(landmarker)


@cache
def tracked():
    take, landmarker = played()
    return track_take(take, stage.person(), stage.landmarks(), landmarker)


@cache
def study():
    take, landmarker = played()
    configs = {name: config for name, config in left_out().items() if name in (FULL, "blendshapes alone")}
    return compare(take, stage.model(), landmarker, configs)


def test_a_repeated_script_is_calm_then_has_every_expression_in_every_round():
    script = repeated_script(30.0, 12.0, seed=3)
    assert [name for name, _, _ in script.cues] == ["calm", *REPEATED, *(f"{name} again" for name in REPEATED)]
    _, start, end = script.cues[0]
    gaze = np.array([name.startswith(("eyeLook", "eyeBlink")) for name in stage.person().names])
    assert script.weights[start : end - 3][:, ~gaze].max() < 0.1
    assert all(script.weights[a:b][:, ~gaze].max() > 0.4 for _, a, b in script.cues[1:])
    ends = [(a, b) for _, a, b in script.cues]
    assert ends[0][0] == 0
    assert all(abs(b - c) <= 1 for (_, b), (c, _) in pairwise(ends))


def test_repeated_scripts_that_cannot_be():
    with pytest.raises(BadInput, match="there is no 'glee'; known are"):
        repeated_script(expressions=("glee",))
    with pytest.raises(BadInput, match=r"seconds: expected at least 6\.5, got 3"):
        repeated_script(seconds=3.0)


def test_the_film_s_hand_comes_between_the_rounds():
    script, film = demo_rgbd.stage(1, 8.0)
    assert film.truth.in_view is not None
    hidden = np.flatnonzero(~film.truth.in_view)
    between = next(a for name, a, _ in script.cues if name.endswith("again"))
    assert 3 <= len(hidden) <= 15
    assert hidden.min() - 2 <= between <= hidden.max() + 2
    assert [name for _, _, name in demo_rgbd.spans(script)] == list(REPEATED) * 2
    assert len(demo_rgbd.shown(script)) == 1 + len(REPEATED)


def test_demo_without_the_landmark_model_is_one_line(tmp_path, monkeypatch, capsys):
    pytest.importorskip("mediapipe")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "nothing.task"))
    with pytest.raises(SystemExit) as stop:
        main(["demo", "rgbd", "-o", str(tmp_path / "out")])
    told = capsys.readouterr().err
    assert stop.value.code == 2
    assert told.count("\n") == 1
    assert "no such file" in told


def test_a_landmarker_remembers_what_it_saw():
    class Once:
        asked = 0

        def detect(self, image, time=None):
            self.asked += 1

    eyes = Remembered(once := Once())
    image = np.zeros((2, 2, 3), np.uint8)
    assert [eyes.detect(image, t) for t in (0.0, 0.1, 0.0, 0.1)] == [None] * 4
    assert once.asked == 2


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


def test_the_whole_tracker_of_a_study_is_that_of_track_take():
    found = study().variants[FULL]
    performance = tracked().performance
    own = [i for i, name in enumerate(performance.rig.names) if not name.startswith(CORRECTIVE)]
    np.testing.assert_allclose(performance.weights[:, own], found.weights, atol=1e-6)
    alone = study().variants["blendshapes alone"]
    assert np.abs(alone.front - found.front).max() > 1e-3


def test_what_a_study_knew_when_and_what_it_could_not_say():
    told = replace(study(), learnt=((3, study().anchors), (6, study().anchors)))
    assert told.known_by(3) is None
    assert told.known_by(4) is told.learnt[0][1]
    rest = told.outside(FRAMES - 1, None)
    moved = told.variants[FULL].front[FRAMES - 1] - told.model.neutral
    np.testing.assert_allclose(rest + told.anchors.project(moved), moved, atol=1e-5)
    np.testing.assert_allclose(told.outside(FRAMES - 1, told.known_by(4)), rest, atol=1e-4)
    whole = told.vertices(FULL, FRAMES - 1)[told.model.front]
    inner = told.model.fade == 1
    np.testing.assert_allclose(whole[inner], told.variants[FULL].front[FRAMES - 1][inner], atol=1e-5)


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


@pytest.fixture
def shell(tmp_path, monkeypatch, capsys):
    """A take on disk and its rig, a landmarker that was told the answers, and a way to call `mien track`."""
    take, landmarker = stage.acted(stage.person(), stage.talk(stage.person(), FRAMES), stage.sway(FRAMES))
    write_rgbd(tmp_path / "take", take)
    write_rig(tmp_path / "rig.glb", stage.person())
    stage.landmarks().save(beside(tmp_path / "rig.glb"))
    told = dict(landmarker.answers)
    monkeypatch.setattr("mien.cli.track.require_landmarker", lambda: None)
    monkeypatch.setattr("mien.tracking.pipeline.FaceLandmarker", lambda mode: stage.Told(told))

    def call(*words: str, rig: str = "rig.glb") -> str:
        place = ["track", str(tmp_path / "take"), "--rig", str(tmp_path / rig), "-o", str(tmp_path / "perf.glb")]
        with pytest.raises(SystemExit) as stop:
            main([*place, *words])
        assert stop.value.code == 2
        line = capsys.readouterr().err.strip().splitlines()[-1]
        assert line.startswith("mien: ")
        return line

    return tmp_path, told, call


def test_a_take_that_breaks_off_keeps_what_was_tracked(shell):
    folder, _, call = shell
    broken = folder / "take" / "depth" / "000009.png"
    broken.write_bytes(broken.read_bytes()[:-3000])
    assert "000009.png: cannot be read to its end" in (line := call())
    assert "the 9 frames before are in" in line
    assert len(read_performance(folder / "perf.glb")) == 9
    assert "The take ended early" in (folder / "perf.html").read_text()
    assert (folder / "perf.png").is_file()


def test_the_scale_that_would_fit_is_named(shell):
    folder, _, call = shell
    (folder / "take" / "take.json").write_text('{"depth_scale": 150, "fps": 30}')
    line = call()
    assert "with 150 units of depth a metre the face is" in line
    assert "--depth-scale 1000 would make it 1" in line
    assert not (folder / "perf.glb").exists()


def test_a_take_without_a_face_is_said_so(shell):
    folder, told, call = shell
    told.update(dict.fromkeys(told))
    assert "no face in the first 30 frames" in call()
    assert not (folder / "perf.glb").exists()


def test_a_rig_without_the_shapes_is_named(shell):
    folder, _, call = shell
    rig = stage.person()
    write_rig(folder / "odd.glb", Rig(rig.neutral, rig.deltas[:2], ("Key_1", "Key_2")))
    assert "odd.glb has none of the ARKit shapes (it has Key_1, Key_2)" in call(rig="odd.glb")


def test_a_take_without_intrinsics_is_said_so(shell):
    folder, _, call = shell
    (folder / "take" / "camera_intrinsic.json").unlink()
    assert "the camera's intrinsics are missing" in call()


def test_frames_that_a_live_source_missed_are_held(shell):
    folder, told, _ = shell
    now = [0.0]
    take = read_rgbd(folder / "take")

    def clock() -> float:
        now[0] += 0.02
        return now[0]

    replay = replace(take, frames=lambda: live_frames(Replay(take, clock=clock, sleep=lambda s: None)))
    out = track_take(replay, stage.person(), stage.landmarks(), stage.Told(told), TrackTakeConfig(live=True))
    assert out.missed > 0
    performance = out.performance
    assert len(performance) == FRAMES
    assert (~performance.tracked).sum() == out.missed + 1  # the first frame's landmarks come with the second
    held = np.flatnonzero(~performance.tracked)[1:]
    np.testing.assert_array_equal(performance.weights[held], performance.weights[held - 1])


def test_colour_alone_is_fitted_by_weights_of_its_own():
    take, landmarker = played()
    colour = replace(take, has_depth=False, frames=lambda: (replace(frame, depth=None) for frame in take))
    moved = []
    for fit in (BlendshapeFitConfig(alone=13.8, scores=0.0), BlendshapeFitConfig(alone=0.0, scores=0.0)):
        config = TrackTakeConfig(video=fit)
        out = track_take(colour, stage.person(), stage.landmarks(), landmarker, config)
        moved.append(out.performance.weights[:, stage.person().index("jawOpen")].max())
        assert not out.learnt
    assert moved[0] > 0.1
    assert moved[1] < 0.02


def test_a_hand_at_another_depth_does_not_end_the_take():
    take, landmarker = played()
    frames = list(take)
    for t in (5, 6, 7):
        frames[t] = replace(frames[t], depth=np.full_like(frames[t].depth, 280.0))
    out = track_take(replace(take, frames=lambda: iter(frames)), stage.person(), stage.landmarks(), landmarker)
    assert out.stopped is None
    assert len(out.performance) == FRAMES
    np.testing.assert_array_equal(np.flatnonzero(~out.performance.tracked), [5, 6, 7])
