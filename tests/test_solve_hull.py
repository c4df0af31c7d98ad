import numpy as np

from mien.solve.hull import hulls, nearest_in_hulls


def test_a_triangle_a_segment_and_a_point_by_hand():
    first, second = [[0, 0], [0, 0], [1, 2]], [[2, 0], [2, 2], [1, 2]]
    seen = np.array([first, second, [[0, 2], [1, 1], [1, 2]], [[0.5, 0.5], [0, 0], [1, 2]]], float)
    asked = np.array([[[0.6, 0.7], [2, 0], [5, 5]], [[2, 2], [3, 3], [1, 2]], [[-1, 1], [0.5, 0.5], [1, 2]]], float)
    found = nearest_in_hulls(asked, hulls(seen))
    expected = [[[0.6, 0.7], [1, 1], [1, 2]], [[1, 1], [2, 2], [1, 2]], [[0, 1], [0.5, 0.5], [1, 2]]]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_was_seen_stays_and_what_is_found_is_the_nearest():
    """Against many convex mixtures of the points seen: none is nearer, and what is found is as near as they come."""
    rng = np.random.default_rng(0)
    seen, asked = rng.normal(size=(12, 3, 2)), 3 * rng.normal(size=(100, 3, 2))
    corners = hulls(seen)
    np.testing.assert_allclose(nearest_in_hulls(seen, corners), seen, atol=1e-9)
    found = nearest_in_hulls(asked, corners)
    np.testing.assert_allclose(nearest_in_hulls(found, corners), found, atol=1e-9)
    mixed = np.einsum("mn,nkd->mkd", rng.dirichlet(np.full(12, 0.1), 5000), seen)
    best = np.linalg.norm(asked[:, None] - mixed, axis=-1).min(axis=1)
    ours = np.linalg.norm(asked - found, axis=-1)
    assert (ours <= best + 1e-9).all()
    assert (best - ours).max() < 0.3
