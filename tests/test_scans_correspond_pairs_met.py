"""How well pairs by hand are met: by hand on a square that is shifted, and as one line."""

import numpy as np

from mien.image_space.constraints import PairConstraint
from mien.scans.correspond.pairs_met import distance_to_line, pair_distances, pairs_met

SQUARE = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])
AT = np.array([[2.0, 3.0, 0.0], [7.0, 6.0, 0.0]])
RIGHT = np.array([1.0, 0.0, 0.0])
ALONG = np.array([[1.0, 5.0, 0.0], [5.0, 5.0, 0.0], [9.0, 5.0, 0.0]])


def held() -> PairConstraint:
    """Two points and a line that are the same on a square and on one moved by (1, 0, 0); the second point 2 mm off."""
    other = AT + RIGHT
    other[1, 1] += 2.0
    return PairConstraint((1, 0), np.stack([AT, other]), ((ALONG, ALONG + RIGHT),))


def moved(up: float) -> np.ndarray:
    """The square moved to the right and up, and the square."""
    return np.stack([SQUARE + RIGHT + np.array([0.0, up, 0.0]), SQUARE])


def test_what_is_carried_along_meets_what_it_belongs_to():
    np.testing.assert_allclose(pair_distances(held(), moved(0.0), FACES), [0, 2, 0], atol=1e-9)
    np.testing.assert_allclose(pair_distances(held(), moved(3.0), FACES), [3, 1, 3], atol=1e-9)


def test_the_line_names_the_worst():
    met = pairs_met([held()], FACES, before=moved(3.0), after=moved(0.0))
    assert met.names == ("point 1", "point 2", "curve 1")
    assert met.told(["frown", "smile"]) == (
        "3 pairs by hand: 2.33 mm off before, 0.67 mm now; the worst is point 2 of smile and frown "
        "(1.00 mm before, 2.00 mm now)"
    )


def test_distance_to_a_line_counts_its_ends():
    line = np.array([[0.0, 0, 0], [4, 0, 0], [4, 0, 0], [4, 4, 0]])
    points = np.array([[-3.0, 4, 0], [2, 1, 0], [4, 6, 0], [6, 2, 0]])
    np.testing.assert_allclose(distance_to_line(points, line), [5, 1, 2, 2])
