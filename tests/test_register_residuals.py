"""Terms of the nonrigid registration: by hand, and their derivatives."""

import numpy as np
import pytest
import scipy.sparse as sp

from hilly_meshes import MESH, all_terms, bent
from mien.register.residuals import marker_term, plane_term, point_term


@pytest.mark.parametrize("name", ["markers", "laplacian", "membrane", "points", "planes"])
def test_derivative_of_each_term(name):
    """The gradient that the solver uses against differences of the cost."""
    rng = np.random.default_rng(2)
    x, way = bent(MESH.vertices), rng.normal(size=MESH.vertices.shape)
    term = all_terms(x)[name]
    r = term.residual(x)
    slope = (term.normals * r[:, None] * way).sum() if name == "planes" else ((term.matrix @ way) * r).sum()
    h = 1e-5
    np.testing.assert_allclose((term.cost(x + h * way) - term.cost(x - h * way)) / (2 * h), 2 * slope, rtol=1e-5)


def test_terms_by_hand():
    x = np.array([[0.0, 0, 0], [1, 0, 0]])
    planes = plane_term(np.array([[0.0, 0, 3], [0, 0, 4]]), np.array([[0.0, 0, 1], [1, 0, 0]]), np.array([2.0, 9.0]))
    np.testing.assert_allclose(planes.cost(x), 2 * 9 + 9 * 1)
    np.testing.assert_allclose(point_term(x + np.array([0, 0, 2]), np.array([1.0, 3.0])).cost(x), 4 + 12)
    middle = sp.csr_matrix(np.array([[0.5, 0.5]]))
    np.testing.assert_allclose(marker_term(middle, np.array([[0.5, 2, 0]]), np.array([5.0])).cost(x), 20)
