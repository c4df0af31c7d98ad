"""Lips that touch are two surfaces."""

import numpy as np

from mien.mesh import Mesh
from mien.register import NonrigidConfig, Rejection, Surface, Template
from mien.register.sides import same_side


def test_matches_to_the_other_side_are_forbidden_by_hand():
    vertices = np.array([[0.0, 1, 0], [0, -1, 0], [9, 0, 0]])
    sides = np.array([1, -1, 0])
    found = np.array([[0.0, -0.9, 0], [0, -0.8, 0], [0, 1, 0]])
    assert same_side(vertices, sides, found).tolist() == [False, True, True]
    assert same_side(vertices, np.zeros(3, int), found).all()
    assert same_side(vertices, np.array([1, -2, 0]), found).all()


def grid(height: float, n: int = 12) -> Mesh:
    """A level sheet, normals up."""
    u, v = np.meshgrid(np.linspace(-20, 20, n), np.linspace(-20, 20, n), indexing="ij")
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack(t, 1) for t in ((a, b, c), (a, c, d))])
    return Mesh(np.stack([u, v, 0 * u + height], -1).reshape(-1, 3), faces)


def test_a_side_is_not_drawn_to_the_other_one_s_surface():
    """Only the upper sheet was scanned: the lower one would jump onto it, and with sides stays where it is."""
    upper, lower = grid(1.0), grid(-1.0)
    n = len(upper.vertices)
    template = Mesh(np.concatenate([upper.vertices, lower.vertices]), np.concatenate([upper.faces, lower.faces + n]))
    sides = np.r_[np.ones(n, int), -np.ones(n, int)]
    config = NonrigidConfig(closest=(2.0,), coarse=(), rejection=Rejection(max_distance=9, boundary=False))
    free, held = (Template(template, 0).register(Surface(upper), None, config, sides=s).vertices for s in (None, sides))
    assert free[n:, 2].mean() > 0.5
    np.testing.assert_allclose(held[n:, 2], -1.0, atol=0.05)
