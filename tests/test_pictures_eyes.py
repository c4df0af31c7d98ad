"""Which parts are eyes."""

import numpy as np

from lit_things import ball, square
from mien.mesh import Mesh
from mien.pictures.eyes import eyeballs


def test_eyes_are_known_by_their_shape():
    head, eye = ball(100.0), ball(14.0, (30.0, 0.0, 90.0), rounds=3)
    tooth = square(5.0, 120.0)
    parts = [head, eye, tooth]
    starts = np.cumsum([0, *(len(p.vertices) for p in parts)])
    faces = np.vstack([p.faces + s for p, s in zip(parts, starts, strict=False)])
    mesh = Mesh(np.vstack([p.vertices for p in parts]), faces)
    found = eyeballs(mesh)
    np.testing.assert_array_equal(np.flatnonzero(found), np.arange(starts[1], starts[2]))
    long = mesh.with_vertices(np.where(found[:, None], mesh.vertices * (1, 1.3, 1), mesh.vertices))
    assert not eyeballs(long).any()
