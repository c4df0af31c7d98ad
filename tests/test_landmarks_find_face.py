"""Where the face is in a scan."""

import numpy as np
import pytest

from face_model import needs_model
from landmark_scans import QUICK, somebody
from mien.errors import BadInput
from mien.landmarks.lift import lift_landmarks
from mien.mesh import Mesh, Scan

pytestmark = needs_model


def test_two_heads_are_refused():
    mesh = somebody()
    n = len(mesh.vertices)
    pair = Mesh(
        np.concatenate([mesh.vertices, mesh.vertices + np.array([260.0, 0, 0])]),
        np.concatenate([mesh.faces, mesh.faces + n]),
        colors=None if mesh.colors is None else np.concatenate([mesh.colors, mesh.colors]),
    )
    with pytest.raises(BadInput, match="two heads"):
        lift_landmarks(Scan(pair, name="pair"), QUICK)


def test_a_thing_without_a_face_is_refused():
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 40), np.linspace(0.01, np.pi - 0.01, 20), indexing="ij")
    ball = np.stack([np.cos(u) * np.sin(v), np.cos(v), np.sin(u) * np.sin(v)], -1).reshape(-1, 3) * 100
    i = np.arange(800).reshape(40, 20)
    quads = [i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()]
    faces = np.concatenate([np.stack([quads[0], quads[1], quads[2]], 1), np.stack([quads[0], quads[2], quads[3]], 1)])
    with pytest.raises(BadInput, match="ball: no face"):
        lift_landmarks(Scan(Mesh(ball, faces), name="ball"), QUICK)


def test_a_point_is_no_scan():
    with pytest.raises(BadInput, match="one point"):
        lift_landmarks(Scan(Mesh(np.ones((3, 3)), np.array([[0, 1, 2]]))), QUICK)
