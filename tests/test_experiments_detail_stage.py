from dataclasses import replace

import numpy as np

from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments.detail_stage import DetailStageConfig, detail_errors, detail_stage, kept_in_memory


def test_a_staged_subject_is_learnt_and_scored():
    """A small one: the medium map brings clips it has seen nearer to the skin than shell and frozen maps do."""
    stage = detail_stage(31, DetailStageConfig(markers=60, frames=4, unseen_frames=3, levels=1))
    training = kept_in_memory(replace(stage.training, clips=stage.training.clips[:3]))
    base = BaseConfig(vertices=3000)
    model = fit_detail(training, DetailConfig(base=base, medium_size=96, fine_size=0))
    errors = detail_errors(model, training, base)
    assert set(errors) == {clip.name for clip in training.clips}
    assert np.mean([e.medium for e in errors.values()]) < 0.7 * np.mean([e.shell for e in errors.values()])
    assert len(next(iter(errors.values())).line().split()) == 4
