"""Which frame is the neutral face."""

from dataclasses import replace

import numpy as np
import pytest

from marker_stage import held, region
from mien.errors import BadInput
from mien.faces import load_face
from mien.fitting.marker_identity import fit_identity
from mien.fitting.terms import surface_points
from mien.markers.neutral import FindNeutralConfig, Neutral, added_share, find_neutral
from mien.register import procrustes
from mien.takes.frame_solve import SolveConfig
from mien.takes.marker_model import marker_model
from mien.transforms import Transform

FRAMES = np.arange(0, 300, 3)


@pytest.fixture(scope="module")
def smiler():
    """A take that smiles for two thirds of its time and rests for a moment: (positions, fit)."""
    face = load_face()
    model = marker_model(face.rig, held(), np.full(60, 3.0))
    W = np.zeros((300, 52))
    rng = np.random.default_rng(0)
    smile = [face.rig.index(f"mouthSmile{side}") for side in ("Left", "Right")]
    W[60:200, smile] = 1.0
    busy = np.abs(np.sin(np.arange(300)[:, None] / 9 + rng.uniform(0, 6, 8)))
    names = ("jawOpen", "browInnerUp", "mouthPucker", "mouthLeft", "noseSneerLeft", "cheekPuff", "browDownLeft")
    W[200:, [face.rig.index(n) for n in names]] = 0.5 * busy[200:, :7]
    W[200:, smile] = 0.8 * busy[200:, 7:]
    X = model.points(W) + 0.03 * rng.normal(size=(300, 60, 3))
    start = procrustes(X[0], surface_points(face.rig.neutral, held(), 3.0)).transform
    return X, fit_identity(X[0], face, region(), start, held())


def test_the_neutral_is_what_the_rest_is_added_to_not_what_was_held_longest(smiler):
    X, fit = smiler
    found = find_neutral(X, FRAMES, load_face().rig, fit, None, SolveConfig(rounds=2, smoothness=0.0))
    assert found.frame < 60
    assert found.added > 0.97
    assert found.rests
    assert "the neutral is frame" in found.line(60.0)


def test_a_held_smile_is_told_as_no_neutral(smiler):
    X, fit = smiler
    at_rest, smiling = (added_share(X, FRAMES, f, load_face().rig, fit, None, SolveConfig()) for f in (30, 100))
    assert smiling < at_rest - 0.03
    assert "may never rest" in Neutral(100, 0.6).line(60.0)
    assert (Neutral(100, 0.89).rests, Neutral(100, 0.91).rests) == (False, True)


def test_a_named_frame_is_taken_and_one_outside_is_refused(smiler):
    X, fit = smiler
    solve = SolveConfig(rounds=2, smoothness=0.0)
    told = find_neutral(X, FRAMES, load_face().rig, fit, None, solve, FindNeutralConfig(frame=120))
    assert told.frame == 120
    assert told.given
    with pytest.raises(BadInput, match="0 to 299"):
        find_neutral(X, FRAMES, load_face().rig, fit, None, solve, FindNeutralConfig(frame=300))


def test_head_motion_left_in_the_take_has_no_say(smiler):
    X, fit = smiler
    moved = replace(fit, T_face_head=Transform(np.eye(3), np.array([0.0, 0, 0.5])) @ fit.T_face_head)
    shares = [added_share(X, FRAMES, 10, load_face().rig, f, None, SolveConfig()) for f in (fit, moved)]
    np.testing.assert_allclose(*shares, atol=0.02)
