"""Held expressions before a staged sensor."""

from dataclasses import replace

import numpy as np

from blendshape_stage import CONFIG, capture
from mien.experiments.blendshapes_stage import EXPRESSIONS, GRADES, capture_weights, graded, single_frames
from mien.faces import load_face
from mien.stage import StagedFilm


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


def test_single_frames_err_as_their_sensor_does():
    take, _, truth = capture("neutral")
    frames = list(take)[:2]
    off = single_frames(StagedFilm(take, truth), frames)
    assert all(0.1 < value < 1.5 for value in off)
    worse = [replace(frame, depth=frame.depth + np.float32(3.0) * (frame.depth > 0)) for frame in frames]
    assert min(single_frames(StagedFilm(take, truth), worse)) > max(off) + 0.5


def test_grades_run_from_low_to_high_and_may_be_filmed():
    noise = [grade.sensor.noise * (grade.distance / 700) ** 2 for grade in GRADES.values()]
    assert noise[0] == max(noise)
    assert all(graded(grade).distance >= grade.sensor.nearest + 150 for grade in GRADES.values())
