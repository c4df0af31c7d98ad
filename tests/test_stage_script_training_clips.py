import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces.arkit import ARKIT_NAMES
from mien.stage.script.training_clips import EXPRESSIONS, UNSEEN, expression_clip, unseen_clip


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_clips_run_from_neutral_to_the_extreme(name):
    weights = expression_clip(name, 12, seed=3)
    assert (weights[0] == 0).all()
    assert {n: round(float(w), 9) for n, w in zip(ARKIT_NAMES, weights[-1], strict=True) if w} == EXPRESSIONS[name]
    assert (np.diff(weights, axis=0) >= -1e-9).all()


def test_units_do_not_move_all_at_once():
    weights = expression_clip("happy", 40)
    moving = weights[:, weights[-1] > 0] / weights[-1, weights[-1] > 0]
    assert np.ptp(moving[20]) > 0.05


@pytest.mark.parametrize("name", UNSEEN)
def test_unseen_clips_are_no_training_clips(name):
    unseen = unseen_clip(name, 10)
    assert (unseen >= -1e-9).all()
    strongest = unseen[unseen.sum(axis=1).argmax()]
    for expression in EXPRESSIONS:
        assert np.abs(strongest - expression_clip(expression, 10)).sum(axis=1).min() > 0.3


def test_what_is_not_there_is_refused():
    with pytest.raises(BadInput, match="expected one of"):
        expression_clip("bliss", 10)
    with pytest.raises(BadInput, match="two frames"):
        expression_clip("happy", 1)
