"""Fine-scale registration: laws, known slides, constraints."""

import numpy as np

from mien.markers.constraints import PairConstraint
from mien.markers.fine import FineConfig, register_fine
from mien.mesh import Mesh, closest_point

COUNT = 61
QUICK = FineConfig(sweeps=2, pixel_mm=1.0)


def sheet(slide=0.0, depth=1.0, wave=0.0):
    """A piece of cylinder with furrows across; its vertices `slide` mm too high, more in the middle than at the rim."""
    angle, y = np.meshgrid(np.linspace(-0.5, 0.5, COUNT), np.linspace(-40, 40, COUNT))
    bump = np.cos(np.pi * angle) ** 2 * np.cos(np.pi * y / 80) ** 2
    at = y + slide * bump
    height = depth * furrows(at, angle) + wave * np.cos(angle * 3)
    x, z = (80 + height) * np.sin(angle), (80 + height) * np.cos(angle)
    return np.stack([x, at, z], -1).reshape(-1, 3)


def furrows(y, angle):
    lines = 0.5 + 0.5 * np.cos(2 * np.pi * (y + 3 * np.sin(4 * angle)) / 12)
    return -(lines**4) * np.exp(-((y / 25) ** 4) - (angle / 0.35) ** 4)


def triangles():
    index = np.arange(COUNT * COUNT).reshape(COUNT, COUNT)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    return np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def regions():
    side = np.tile(np.linspace(0, 1, COUNT), (COUNT, 1)).ravel()
    return {"right": np.clip(3 - 5 * side, 0, 1), "left": np.clip(5 * side - 2, 0, 1)}


FACES = triangles()
INNER = (np.abs(sheet()[:, 1]) < 22) & (np.abs(sheet()[:, 0]) < 20)


def test_identical_scans_stay_as_they_are():
    found = register_fine(np.stack([sheet()] * 3), FACES, regions(), config=QUICK)
    np.testing.assert_allclose(found.vertices, np.stack([sheet()] * 3), atol=0.02)
    np.testing.assert_allclose(found.moved, 0, atol=0.01)
    np.testing.assert_allclose(found.errors, 0, atol=1e-3)
    assert not found.unreliable.any()


def test_a_slide_is_undone():
    shapes = np.stack([sheet(), sheet(), sheet(), sheet(2.0)])
    found = register_fine(shapes, FACES, regions(), config=QUICK)
    off = np.linalg.norm(found.vertices - sheet(), axis=2)[:, INNER].mean(axis=1)
    assert np.linalg.norm(shapes[3] - sheet(), axis=1)[INNER].mean() > 1.0
    assert off[3] < 0.3
    assert off[:3].max() < 0.3
    assert (found.errors[3] < 0.5 * found.before[3]).all()


def test_points_that_are_the_same_meet():
    """Two sheets without a feature: what is pointed out alone moves them."""
    shapes = np.stack([sheet(depth=0.0), sheet(depth=0.0)])
    below, above = np.array([[0.0, -6.0, 80.0]]), np.array([[0.0, 2.0, 80.0]])
    held = PairConstraint((0, 1), np.stack([below, above]))
    found = register_fine(shapes, FACES, regions(), config=QUICK, constraints=[held])
    meshes = [Mesh(v, FACES) for v in found.vertices]
    there = closest_point(meshes[0], below).attachment().points(meshes[1])
    np.testing.assert_allclose(there, above, atol=0.5)
