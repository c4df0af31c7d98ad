"""Scores by material points: the truth scores nothing, a frozen face one."""

import numpy as np

from mien.mesh import mass
from mien.stage.score_material import material_under, scan_errors, score_material
from scan_stage import scan_stage


def test_the_truth_scores_nothing_and_a_frozen_face_scores_one():
    actor, take, _, scans = scan_stage()
    truth, some = take.truth, np.flatnonzero(actor.skin)[::9]
    frames, areas = np.arange(0, 140, 7), mass(actor.neutral.vertices, actor.neutral.faces)[some]
    moving = score_material(
        lambda f: actor.vertices(truth.weights[[f]])[0][some], truth.T_lab_face, truth, 0, frames, areas
    )
    assert moving.error.max() < 1e-6
    mean = actor.vertices(truth.weights[frames]).mean(axis=0)[some]
    still = actor.vertices(truth.weights[[0]])[0][some]
    frozen = score_material(lambda f: mean if f else still, truth.T_lab_face, truth, 0, frames, areas)
    assert 0.9 < frozen.ratio < 1.0 + 1e-6
    true = [s.truth.T_scan_face.inverse().apply(s.truth.vertices) for s in scans]
    T = [s.truth.T_scan_face.inverse() for s in scans]
    assert scan_errors([x[some] for x in true], T, scans).max() < 1e-6
    assert material_under(actor, true[0], true[0][some])[1].max() < 1e-9
