"""Coarse to fine with any inner solver."""

import numpy as np

from mien.flow import Solved, coarse_to_fine, pyramid


def test_each_level_starts_from_the_enlarged_flow_of_the_coarser_one():
    image = np.zeros((40, 64, 1))
    weight = np.ones((40, 64))
    levels = pyramid(image, image, weight, weight)
    starts = []

    def add_one(level, start):
        starts.append(start)
        h, w = level.source_weight.shape
        return Solved(start + 1, True, 1, np.zeros((1, 1)), np.zeros((h, w)))

    results = coarse_to_fine(levels, add_one)
    assert [r.flow.shape for r in results] == [(*level.source.shape[:2], 2) for level in levels[::-1]]
    assert not starts[0].any()
    expected = np.ones(2)
    for start, result, coarse in zip(starts[1:], results[1:], results, strict=False):
        ratio = np.array(result.flow.shape[1::-1]) / coarse.flow.shape[1::-1]
        np.testing.assert_allclose(start, np.broadcast_to(expected * ratio, start.shape), rtol=1e-5)
        expected = expected * ratio + 1
