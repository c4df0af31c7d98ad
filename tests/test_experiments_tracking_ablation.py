"""The tracker without each of its parts."""

from dataclasses import replace
from functools import cache

import numpy as np

import tracking_stage as stage
from mien.experiments.tracking_ablation import FULL, Remembered, compare, left_out
from mien.rig.retarget import CORRECTIVE
from mien.tracking.pipeline import TrackTakeConfig, track_take
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from mien.tracking.tracker_context import TrackConfig
from rgbd_study import FRAMES, played


@cache
def study():
    take, landmarker = played()
    configs = {name: config for name, config in left_out().items() if name in (FULL, "blendshapes alone")}
    return compare(take, stage.model(), landmarker, configs)


def test_a_landmarker_remembers_what_it_saw():
    class Once:
        asked = 0

        def detect(self, image, time=None):
            self.asked += 1

    eyes = Remembered(once := Once())
    image = np.zeros((2, 2, 3), np.uint8)
    assert [eyes.detect(image, t) for t in (0.0, 0.1, 0.0, 0.1)] == [None] * 4
    assert once.asked == 2


def test_the_whole_tracker_of_a_study_is_that_of_track_take():
    found = study().variants[FULL]
    take, landmarker = played()
    once = TrackTakeConfig(track=TrackConfig(fit=BlendshapeFitConfig(in_use=0.0)))
    performance = track_take(take, stage.person(), stage.landmarks(), landmarker, once).performance
    own = [i for i, name in enumerate(performance.rig.names) if not name.startswith(CORRECTIVE)]
    np.testing.assert_allclose(performance.weights[:, own], found.weights, atol=1e-6)
    alone = study().variants["blendshapes alone"]
    assert np.abs(alone.front - found.front).max() > 1e-3


def test_what_a_study_knew_when_and_what_it_could_not_say():
    told = replace(study(), learnt=((3, study().anchors), (6, study().anchors)))
    assert told.known_by(3) is None
    assert told.known_by(4) is told.learnt[0][1]
    rest = told.outside(FRAMES - 1, None)
    moved = told.variants[FULL].front[FRAMES - 1] - told.model.neutral
    np.testing.assert_allclose(rest + told.anchors.project(moved), moved, atol=1e-5)
    np.testing.assert_allclose(told.outside(FRAMES - 1, told.known_by(4)), rest, atol=1e-4)
    whole = told.vertices(FULL, FRAMES - 1)[told.model.front]
    inner = told.model.fade == 1
    np.testing.assert_allclose(whole[inner], told.variants[FULL].front[FRAMES - 1][inner], atol=1e-5)
