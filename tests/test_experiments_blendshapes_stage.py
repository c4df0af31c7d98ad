"""Held expressions before a staged sensor."""

import numpy as np

from blendshape_stage import CONFIG, capture
from mien.experiments.blendshapes_stage import EXPRESSIONS, capture_weights
from mien.faces import load_face


def test_the_expression_is_held_while_the_head_turns_to_both_sides():
    truth = capture("neutral")[2]
    assert np.ptp(truth.weights, axis=0).max() == 0
    yaw = np.arcsin(np.clip(truth.T_lab_face.rotation[:, 0, 2], -1, 1))
    assert yaw.min() < -0.7 * CONFIG.sweep
    assert yaw.max() > 0.7 * CONFIG.sweep


def test_expressions_are_of_the_rigs_units():
    names = load_face().rig.names
    assert all(unit in names for units in EXPRESSIONS.values() for unit in units)
    assert capture_weights("jawOpen")[names.index("jawOpen")] == EXPRESSIONS["jawOpen"]["jawOpen"]
