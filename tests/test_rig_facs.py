"""The paper's 23 expressions."""

import numpy as np

from mien.rig import Rig
from mien.rig.facs import FACS23
from mien.rig.transfer import merged
from sheet_rigs import sheet


def test_there_are_23_expressions_and_a_merged_one_is_the_sum():
    assert len(FACS23) == 23
    names = tuple(dict.fromkeys(name for parts in FACS23.values() for name in parts))
    deltas = np.random.default_rng(1).normal(size=(len(names), 16, 3))
    rig = Rig(sheet(4), deltas, names)
    whole = merged(rig)
    expected = deltas[names.index("browDownLeft")] + deltas[names.index("browDownRight")]
    np.testing.assert_array_equal(whole.deltas[whole.index("browDown")], expected)
