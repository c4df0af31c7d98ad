"""Studies on the stage, small: a coarse skin, three clips of four frames, 60 markers."""

from dataclasses import replace

import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.synthesize import SynthesisConfig
from mien.detail.transfer.wrinkle_shapes import wrinkle_shapes
from mien.experiments import detail_study
from mien.experiments.detail_stage import DetailStageConfig, detail_stage, kept_in_memory
from mien.experiments.detail_study import (
    placement_errors,
    reflectance_errors,
    staged_performance,
    storage_bytes,
    transfer_errors,
)

STAGED = DetailStageConfig(markers=60, frames=4, unseen_frames=3, levels=1, dot_radius_mm=1.5)
CONFIG = DetailConfig(base=BaseConfig(vertices=2000), medium_size=96, fine_size=0)


def few(stage):
    """The stage with three of its training clips, made once, and one unseen."""
    training = kept_in_memory(replace(stage.training, clips=stage.training.clips[:3]))
    return replace(stage, training=training, unseen=replace(stage.unseen, clips=stage.unseen.clips[:1]))


@pytest.fixture(scope="module")
def stage():
    return few(detail_stage(31, STAGED))


@pytest.fixture(scope="module")
def model(stage):
    return fit_detail(stage.training, CONFIG)


def test_another_person_s_wrinkles_from_one_scan_beat_the_shell_and_the_static_map(stage, model):
    other = few(detail_stage(32, STAGED, like=stage))
    off = np.linalg.norm(other.training.markers - stage.training.markers, axis=1)
    assert 0.5 < np.median(off) < 15
    errors = [e for _, e in transfer_errors(model, other, CONFIG)]
    shell, static, full = (np.mean([getattr(e, name) for e in errors]) for name in ("shell", "frozen", "full"))
    assert full < 0.75 * shell
    assert full < static


def test_albedo_comes_nearer_than_the_neutral_s_also_under_the_dots(stage, model):
    clean = few(detail_stage(31, replace(STAGED, dot_radius_mm=0.0)))
    for static, learnt in reflectance_errors(model, clean.training, CONFIG.base).values():
        assert learnt < 0.8 * static


def test_other_markers_do_worse_than_the_training_s_own(stage, model, monkeypatch):
    monkeypatch.setattr(detail_study, "SHIFTS_MM", (0.0, 4.0))
    monkeypatch.setattr(detail_study, "COUNTS", (30,))
    found = {name: full / shell for name, shell, full in placement_errors(stage, model, CONFIG.base)}
    assert list(found) == ["as trained", "shifted by 4 mm", "30 other markers"]
    assert found["as trained"] < min(found["shifted by 4 mm"], found["30 other markers"]) < 1.2


def test_eight_shapes_keep_a_staged_face_s_detail(stage, model):
    played = staged_performance(stage)
    assert len(played) == 3 * 4 + 3
    _, wrinkles = wrinkle_shapes(model, played, SynthesisConfig())
    assert wrinkles.kept > 0.9


def test_bytes_are_those_of_surfaces_and_coefficients():
    clips = training()
    model = fit_detail(clips, DetailConfig(base=BaseConfig(vertices=0), medium_size=24, fine_size=0))
    data, maps, halves = storage_bytes(clips, model)
    assert data == 16 * 33 * 33 * 3 * 4
    assert maps == len(model.medium.texels.pixels) * 18 * 4
    assert halves == maps // 2
