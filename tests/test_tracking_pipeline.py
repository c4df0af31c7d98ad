"""Whole takes: live, of colour alone, with a hand in them."""

from dataclasses import replace

import numpy as np
import pytest

import tracking_stage as stage
from mien.rgbd import read_rgbd
from mien.rgbd.live import Replay, live_frames
from mien.tracking.pipeline import TrackTakeConfig, track_take
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from rgbd_study import FRAMES, played, track_shell


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
