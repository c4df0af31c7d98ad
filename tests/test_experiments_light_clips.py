from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments.light_clips import NEUTRAL, LightClipsConfig, chain_errors, staged_captures, write_staged_takes
from mien.experiments.light_stage import LightStageConfig
from mien.light.disk.training_clips import read_clip_takes
from mien.mesh import Mesh
from mien.stage import SkinConfig, make_performer, make_skin
from mien.transforms import Transform

TINY = LightClipsConfig(stage=LightStageConfig(size=(54, 72), projector=(128, 96)), clips={"happy": 2}, unseen=())


@pytest.fixture(scope="module")
def skin():
    return make_skin(make_performer(5), SkinConfig(levels=1, eyes_and_teeth=False), 5)


def test_takes_are_written_as_a_rig_leaves_them(skin, tmp_path):
    truth = write_staged_takes(tmp_path, skin, TINY)
    takes, notes = read_clip_takes(tmp_path)
    assert notes == []
    assert {name: len(take) for name, take in takes.items()} == {NEUTRAL: 1, "happy": 2}
    assert {name: len(meshes) for name, meshes in truth.items()} == {NEUTRAL: 1, "happy": 2}
    assert takes["happy"].capture(1)["left"].shape == (12, 72, 54)


def test_a_face_moves_within_a_capture_and_the_neutral_does_not(skin):
    (neutral,) = staged_captures(skin, NEUTRAL, 1, TINY, 0)
    first, _ = staged_captures(skin, "happy", 2, TINY, 0)
    assert (neutral.ends[0] == neutral.ends[1]).all()
    assert 0.2 < np.linalg.norm(first.ends[1] - first.ends[0], axis=1).max() < 5
    np.testing.assert_array_equal(neutral.T_rig_face.translation, first.T_rig_face.translation)


def test_the_truth_itself_is_no_way_off_and_maps_beat_the_shell():
    clips = training()
    model = fit_detail(clips, DetailConfig(medium_size=48, fine_size=96, high_pass_mm=4.0))
    faces = clips.mesh.faces
    truth = {c.name: [Mesh(np.asarray(f.vertices, float), faces) for f in c.frames()] for c in clips.clips}
    errors = chain_errors(model, clips, {NEUTRAL: [clips.mesh]} | truth, Transform.identity())
    assert set(errors) == {clip.name for clip in clips.clips}
    for error in errors.values():
        assert max(error.scan, error.again) < 1e-6
        assert error.full < error.shell
    ahead = Transform(np.eye(3), np.array([0.0, 0.0, 1.0]))
    moved = {
        name: [replace(mesh, vertices=ahead.apply(mesh.vertices)) for mesh in meshes] for name, meshes in truth.items()
    }
    off = chain_errors(model, clips, {NEUTRAL: [clips.mesh]} | moved, Transform.identity())
    assert all(error.again == pytest.approx(1.0) for error in off.values())
