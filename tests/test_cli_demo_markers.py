"""`mien demo markers`: what is staged goes through a file before it is solved."""

import numpy as np
import pytest

from mien.cli.demo_markers import demo_markers
from mien.io.markers import read_markers


class Enough(Exception):
    """The take has come as far as the solver."""


def test_the_take_that_is_solved_is_the_one_that_was_written(tmp_path, monkeypatch):
    given = []

    def solver(markers, *_, **__):
        given.append(markers)
        raise Enough

    monkeypatch.setattr("mien.markers.pipeline.solve_take", solver)
    with pytest.raises(Enough):
        demo_markers(tmp_path, 3, 10.0, 30)
    written = read_markers(tmp_path / "take.c3d")
    assert given[0].labels == written.labels
    assert (written.positions.shape[1], written.rate) == (30, 60.0)
    np.testing.assert_array_equal(given[0].positions, written.positions)
    assert {file.name for file in tmp_path.iterdir()} == {"take.c3d"}
