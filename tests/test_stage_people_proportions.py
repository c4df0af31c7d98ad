"""Anatomical warps: faces that the identity space reaches half-way."""

import numpy as np

from mien.faces.bundled import load_face
from mien.stage import STRANGER
from mien.stage.people.make_performer import random_shape
from mien.stage.people.proportions import WARPS, warp_shape


def explained(shape: np.ndarray) -> float:
    """Share of a displacement's variance over the face, rigid motion apart, that the identity space holds."""
    face = load_face()
    skin = face.regions["face"] > 0.5
    points = face.rig.neutral.vertices[skin]
    turns = np.stack([np.cross(axis, points - points.mean(axis=0)).ravel() for axis in np.eye(3)])
    rigid = np.linalg.qr(np.concatenate([np.tile(np.eye(3), (1, len(points))), turns]).T)[0]
    modes = face.identity.modes[:, skin].reshape(len(face.identity.modes), -1).T
    modes, own = (x - rigid @ (rigid.T @ x) for x in (modes, shape[skin].ravel()))
    space = np.linalg.qr(modes)[0]
    return float(((space.T @ own) ** 2).sum() / (own**2).sum())


def test_about_half_of_a_strangers_shape_lies_in_the_identity_space():
    shapes = [random_shape(load_face(), STRANGER, np.random.default_rng(seed)) for seed in range(6)]
    shares = [explained(shape) for shape in shapes]
    assert 0.3 < np.mean(shares) < 0.6
    assert max(shares) < 0.75


def test_warps_change_what_they_name(monkeypatch):
    face = load_face()
    monkeypatch.setattr("mien.stage.people.proportions.STRETCH", (0.0, 0.0, 0.0))
    monkeypatch.setattr("mien.stage.people.proportions.WARPS", {"jaw angle": WARPS["jaw angle"]})
    moved = np.linalg.norm(warp_shape(face, 0.0, np.random.default_rng(1)), axis=1)
    widest = face.rig.neutral.vertices[moved.argmax()]
    assert abs(widest[0]) > 40
    assert widest[1] < -40
    assert moved[face.rig.neutral.vertices[:, 1] > 30].max() < 0.05
    np.testing.assert_allclose(moved, moved[face.mirror], atol=0.2)
