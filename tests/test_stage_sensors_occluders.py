"""What comes before the face."""

import numpy as np

from mien.cli import demo_rgbd
from mien.stage.script.repeated_script import REPEATED


def test_the_film_s_hand_comes_between_the_rounds():
    script, film = demo_rgbd.stage(1, 8.0)
    assert film.truth.in_view is not None
    hidden = np.flatnonzero(~film.truth.in_view)
    between = next(a for name, a, _ in script.cues if name.endswith("again"))
    assert 3 <= len(hidden) <= 15
    assert hidden.min() - 2 <= between <= hidden.max() + 2
    assert [name for _, _, name in demo_rgbd.spans(script)] == list(REPEATED) * 2
    assert len(demo_rgbd.shown(script)) == 1 + len(REPEATED)
