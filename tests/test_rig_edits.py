from dataclasses import replace

import numpy as np
import pytest

from mien.rig.edits import FADE_S, Edits, Key, apply_edits, correction
from studio_things import RATE, nodding


def test_a_correction_steps_smoothly_from_key_to_key_and_fades():
    keys = (Key(1.0, 0.4), Key(2.0, -0.2))
    times = np.array([0.0, 1 - FADE_S / 2, 1.0, 1.5, 2.0, 2 + FADE_S, 9.0])
    np.testing.assert_allclose(correction(keys, times, FADE_S), [0, 0.2, 0.4, 0.1, -0.2, 0, 0], atol=1e-9)


def test_weights_stay_within_bounds_and_other_shapes_as_they_are():
    performance = nodding(31)
    edits = Edits({"jawOpen": (Key(0.5, 5.0),), "wagEars": (Key(0.1, 1.0),)})
    edited, unknown = apply_edits(performance, edits)
    jaw = performance.rig.index("jawOpen")
    assert unknown == ("wagEars",)
    assert edited.weights[15, jaw] == pytest.approx(1.0)
    np.testing.assert_array_equal(np.delete(edited.weights, jaw, 1), np.delete(performance.weights, jaw, 1))
    wild = replace(performance, weights=performance.weights * 1.5)
    kept = apply_edits(wild, Edits({"jawOpen": (Key(0.5, 0.0),)}))[0]
    np.testing.assert_allclose(kept.weights, wild.weights)


def test_a_bad_range_is_bridged_from_end_to_end():
    performance = nodding(31)
    edited, _ = apply_edits(performance, Edits({}, ((10 / RATE, 19 / RATE),)))
    assert edited.tracked.sum() == 21
    middle = (performance.weights[9] + performance.weights[20]) / 2
    np.testing.assert_allclose((edited.weights[14] + edited.weights[15]) / 2, middle, atol=1e-12)
    np.testing.assert_array_equal(edited.weights[20:], performance.weights[20:])
    place = performance.T_world_face.translation
    np.testing.assert_allclose(edited.T_world_face.translation[10], place[9] + (place[20] - place[9]) / 11)
    turns = edited.T_world_face.rotation
    np.testing.assert_allclose(turns @ np.swapaxes(turns, 1, 2), np.broadcast_to(np.eye(3), turns.shape), atol=1e-9)


def test_a_layer_without_corrections_changes_nothing():
    performance = nodding(5)
    edits = Edits({})
    assert len(edits) == 0
    np.testing.assert_array_equal(apply_edits(performance, edits)[0].weights, performance.weights)
