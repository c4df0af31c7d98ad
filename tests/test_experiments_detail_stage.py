import numpy as np

from detail_staged import CONFIG, learnt, subject
from mien.experiments.detail_stage import detail_errors


def test_a_staged_subject_is_learnt_and_scored():
    """A small one: the medium map brings clips it has seen nearer to the skin than shell and frozen maps do."""
    training = subject().training
    errors = detail_errors(learnt(), training, CONFIG.base)
    assert set(errors) == {clip.name for clip in training.clips}
    medium, shell, frozen = (np.mean([getattr(e, n) for e in errors.values()]) for n in ("medium", "shell", "frozen"))
    assert medium < 0.7 * shell
    assert medium < frozen
    assert len(next(iter(errors.values())).line().split()) == 4
