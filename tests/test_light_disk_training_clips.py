"""A dotted ball in two clips of two captures, decoded by a stand-in, written and read as `mien detail fit` does."""

import numpy as np
import pytest

import light_dots
import light_scene
from mien.detail.disk.clips import read_training
from mien.errors import BadInput
from mien.light.disk import training_clips
from mien.light.disk.light_take import LightTake
from mien.light.disk.training_clips import read_clip_takes, write_training_clips
from mien.light.patterns import paper_set
from mien.light.training.clips import TrainingConfig
from mien.light.training.common_surface import CommonConfig
from mien.light.training.dots import DotConfig

CONFIG = TrainingConfig(
    dots=DotConfig(radius_mm=light_dots.RADIUS_MM), common=CommonConfig(grid_mm=2.0, relief_mm=4.0, refine=False)
)


class Take(LightTake):
    """Its captures are poses of the ball."""

    def __len__(self):
        return 3

    def capture(self, number):
        return {"left": number}


def decoded(images, patterns, rig, config):
    if images["left"] == 1:
        raise BadInput("all dark")
    return light_dots.scan(light_dots.pose((0.0, 0.03 * images["left"], 0.0)), ripple=0.4)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clips")
    take = Take(paper_set(256, 192), light_scene.rig(), {"left": ()})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training_clips, "decode_capture", decoded)
        told = write_training_clips(folder, {"glee": take, "woe": take}, config=CONFIG)
    return folder, told


def test_what_is_written_is_a_training_set(written):
    folder, told = written
    training, notes = read_training(folder)
    assert notes == []
    assert [clip.name for clip in training.clips] == ["glee", "woe"]
    assert len(training) == told.frames == 4
    assert len(training.mesh.vertices) == told.vertices
    assert len(training.labels) >= 0.8 * told.dots
    assert training.mesh.vertices[:, 2].max() > 10
    frames = list(training.clips[0].frames())
    assert np.isfinite(frames[0].vertices).mean() > 0.95
    assert training.markers[0, 1] > training.markers[-1, 1]


def test_a_capture_that_fails_is_named(written):
    assert written[1].notes == ("glee, capture 1 left out: all dark", "woe, capture 1 left out: all dark")


def test_a_folder_without_clips_is_told(tmp_path):
    with pytest.raises(BadInput, match="no clips in it"):
        read_clip_takes(tmp_path)
    (tmp_path / "glee").mkdir()
    with pytest.raises(BadInput, match="patterns"):
        read_clip_takes(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="expected a folder"):
        read_clip_takes(tmp_path / "file")
