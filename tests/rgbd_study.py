"""A staged RGB-D take, tracked, and a study of it."""

from functools import cache

import tracking_stage as stage
from mien.experiments.tracking_ablation import Remembered
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
