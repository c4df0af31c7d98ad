"""Values at points of a surface carried over all of it."""

import numpy as np
import scipy.sparse as sp

from mien.mesh import Attachment, Mesh
from mien.register.interpolate import green_functions, interpolate_from_points


def sheet(side: int = 15) -> Mesh:
    """A flat square of 10 mm cells."""
    y, x = np.mgrid[:side, :side] * 10.0
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    lower = np.stack([first, first + 1, first + side], 1)
    upper = np.stack([first + 1, first + side + 1, first + side], 1)
    return Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), np.concatenate([lower, upper]))


def places(mesh: Mesh, count: int = 12) -> Attachment:
    """Random triangles' centres."""
    return Attachment(np.random.default_rng(0).choice(len(mesh.faces), count, False), np.full((count, 3), 1 / 3))


def test_green_functions_are_symmetric_between_points_and_fade():
    mesh, held = sheet(), places(sheet())
    D = held.matrix(mesh)
    pulled = green_functions(mesh, D, 15.0)
    between = D @ pulled
    np.testing.assert_allclose(between, between.T, atol=1e-9 * between.max())
    far = np.linalg.norm(mesh.vertices - held.points(mesh)[0], axis=1) > 80
    assert np.abs(pulled[far, 0]).max() < 0.05 * pulled[:, 0].max()


def test_values_are_met_exactly_or_smoothed():
    mesh, held = sheet(), places(sheet())
    D, values = held.matrix(mesh), np.random.default_rng(1).normal(size=12)
    exact, soft = (interpolate_from_points(mesh, held, 15.0, stiffness) @ values for stiffness in (0.0, 1.0))
    np.testing.assert_allclose(D @ exact, values, atol=1e-8)
    assert np.abs(D @ soft).sum() < np.abs(values).sum()


def test_the_spline_is_the_ridge_solution_of_its_energy():
    mesh, held = sheet(8), places(sheet(8), 5)
    D = held.matrix(mesh).toarray()
    energy = np.linalg.inv(green_functions(mesh, sp.csr_matrix(np.eye(len(mesh.vertices))), 15.0))
    direct = np.linalg.solve(D.T @ D + 0.3 * energy, D.T)
    np.testing.assert_allclose(interpolate_from_points(mesh, held, 15.0, 0.3), direct, atol=1e-6)


def test_what_may_not_move_does_not():
    mesh, held = sheet(), places(sheet())
    some = np.flatnonzero(mesh.vertices[:, 0] < 90)
    S = interpolate_from_points(mesh, held, 15.0, 1.0, some)
    assert not S[mesh.vertices[:, 0] > 95].any()
