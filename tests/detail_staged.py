"""A staged subject, small: a coarse skin, three clips of four frames, 60 markers; made once for all tests."""

from dataclasses import replace
from functools import cache

from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.experiments.detail_stage import DetailStageConfig, detail_stage, kept_in_memory

SEED = 31
STAGED = DetailStageConfig(markers=60, frames=4, unseen_frames=3, levels=1, dot_radius_mm=1.5)
CONFIG = DetailConfig(base=BaseConfig(vertices=2000), medium_size=96, fine_size=0)


def few(stage):
    """The stage with three of its training clips, made once, and one unseen."""
    training = kept_in_memory(replace(stage.training, clips=stage.training.clips[:3]))
    unseen = kept_in_memory(replace(stage.unseen, clips=stage.unseen.clips[:1]))
    return replace(stage, training=training, unseen=unseen)


@cache
def subject():
    """Clips of dotted colours."""
    return few(detail_stage(SEED, STAGED))


@cache
def learnt():
    """Maps of the subject."""
    return fit_detail(subject().training, CONFIG)
