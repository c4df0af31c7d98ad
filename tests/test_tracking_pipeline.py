"""Whole takes: live, of colour alone, with a hand in them."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.rgbd import read_rgbd
from mien.rgbd.live import Replay, live_frames
from mien.tracking.pipeline import TrackTakeConfig, track_take
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from mien.tracking.tracker_context import TrackConfig
from rgbd_study import FRAMES, played, track_shell


class Heard:
    """Progress, and the stages that it was told of."""

    def __init__(self):
        self.stages = []

    def update(self, stage, done, total):
        self.stages.append(stage)


@pytest.fixture
def shell(tmp_path, monkeypatch, capsys):
    return track_shell(tmp_path, monkeypatch, capsys)


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


def test_a_take_is_tracked_anew_with_the_shapes_that_it_taught(monkeypatch):
    """A live source, a hidden face and colour alone are walked through once, as is a take that teaches nothing."""
    take, landmarker = played()
    rig, asked = stage.person(), []
    smaller = replace(rig, deltas=0.5 * rig.deltas)

    def halved(first, config, progress):
        asked.append(first)
        return smaller if first.model.rig is rig else first.model.rig

    monkeypatch.setattr("mien.tracking.pipeline.relearn_shapes", halved)
    seen, heard = [], Heard()
    again = track_take(take, rig, stage.landmarks(), landmarker, progress=heard, watch=seen.append)
    assert len(seen) == 3 * FRAMES
    assert heard.stages == ["tracking"] * FRAMES + ["tracking once more"] * 2 * FRAMES
    np.testing.assert_array_equal(again.performance.rig.deltas[:52], smaller.deltas)
    first, second = asked
    assert second.model.rig is smaller
    np.testing.assert_array_equal(second.fitted, again.fitted)
    assert first.performance.rig.names[:52] == rig.names
    placed = first.T_world_camera.inverse() @ first.performance.T_world_face
    assert placed.translation[:, 2].min() > 300  # before the camera
    jaw = rig.index("jawOpen")
    assert again.performance.weights[:, jaw].max() > 1.3 * first.performance.weights[:, jaw].max()
    for config in (TrackTakeConfig(live=True), TrackTakeConfig(hidden="upper")):
        track_take(take, rig, stage.landmarks(), landmarker, config)
    colour = replace(take, has_depth=False, frames=lambda: (replace(frame, depth=None) for frame in take))
    track_take(colour, rig, stage.landmarks(), landmarker)
    assert len(asked) == 2
    monkeypatch.setattr("mien.tracking.pipeline.relearn_shapes", lambda first, config, progress: rig)
    once = []
    track_take(take, rig, stage.landmarks(), landmarker, watch=once.append)
    assert len(once) == 2 * FRAMES


def test_shapes_that_a_take_hardly_uses_are_left_out_once_it_is_known():
    """A take too short for shapes to be relearnt: the second walk has the dearer prices alone."""
    take, landmarker = played()
    used = []
    for in_use in (0.0, 0.1):
        config = TrackTakeConfig(track=TrackConfig(fit=BlendshapeFitConfig(in_use=in_use)))
        seen = []
        out = track_take(take, stage.person(), stage.landmarks(), landmarker, config, watch=seen.append)
        assert len(seen) == (2 if in_use else 1) * FRAMES
        used.append(np.sqrt((out.fitted**2).mean(0)))
    before, after = used
    idle = before < 0.05
    assert after[idle].sum() < 0.6 * before[idle].sum()
    jaw = stage.person().index("jawOpen")
    assert abs(after[jaw] - before[jaw]) < 0.1 * before[jaw]
