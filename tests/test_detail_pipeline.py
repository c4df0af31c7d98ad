import numpy as np
import pytest

from detail_patch import training
from mien.clip import Markers
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.frames import write_film, write_frames
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.pipeline import synthesize
from mien.detail.synthesize import SynthesisConfig
from mien.errors import BadInput
from mien.io.meshes.ply import read_ply


class Watch:
    def __init__(self):
        self.seen = []

    def update(self, stage, done, total):
        self.seen.append((stage, done, total))


@pytest.fixture(scope="module")
def scene():
    clips, watch = training(), Watch()
    config = DetailConfig(base=BaseConfig(vertices=0), medium_size=24, fine_size=24)
    return fit_detail(clips, config, watch), Markers(clips.clips[0].markers, clips.labels, 30.0), watch


def test_progress_runs_through_both_maps(scene):
    assert scene[2].seen[-1] == ("fine map", 16, 16)
    assert ("medium map", 16, 16) in scene[2].seen


def test_a_take_becomes_as_many_frames(scene, tmp_path):
    model, take, _ = scene
    watch = Watch()
    synthesizer, drive, frames = synthesize(model, take, SynthesisConfig(), watch)
    assert write_frames(tmp_path / "out", synthesizer, drive, frames) == 8
    assert watch.seen[-1] == ("synthesis", 8, 8)
    mesh, _ = read_ply(tmp_path / "out" / "frame_000000.ply")
    np.testing.assert_allclose(mesh.uv, model.base.uv, atol=1e-6)


def test_a_film_is_written_and_a_file_is_no_folder(scene, tmp_path):
    model, take, _ = scene
    synthesizer, drive, frames = synthesize(model, take)
    assert write_film(tmp_path / "a.mp4", synthesizer, list(frames)[:2], 30.0) == 2
    with pytest.raises(BadInput, match="a file"):
        write_frames(tmp_path / "a.mp4", synthesizer, drive, [])
