"""A staged RGB-D take, tracked, and a study of it."""

from functools import cache

import pytest

import tracking_stage as stage
from mien.cli.main import main
from mien.cli.personalize import beside
from mien.experiments.tracking_ablation import Remembered
from mien.io.gltf import write_rig
from mien.rgbd import write_rgbd
from mien.tracking.pipeline import track_take

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


def track_shell(tmp_path, monkeypatch, capsys):
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
