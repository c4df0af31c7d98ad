from dataclasses import replace

import numpy as np
import pytest

from face_model import needs_model
from landmark_scans import QUICK, somebody
from mien.faces.bundled import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.landmarks.lift import lift_landmarks
from mien.mesh import Mesh, Scan, submesh
from mien.transforms import Transform, rotation_from_vector

pytestmark = needs_model


@pytest.fixture(scope="module")
def somewhere():
    """Somebody's front half in centimetres, inside out, lying on a side; and where landmarks truly are."""
    mesh = somebody()
    T = Transform(rotation_from_vector(np.array([0.3, 0.2, 1.7])), np.array([40.0, -70, 90]), 0.1)
    moved = mesh.with_vertices(T.apply(mesh.vertices))
    truth = bundled_landmarks().attachment.points(moved)
    front, _ = submesh(moved, mesh.vertices[mesh.faces, 2].min(axis=1) > 10)
    return Mesh(front.vertices, front.faces[:, ::-1], colors=front.colors), truth, T


@pytest.fixture(scope="module")
def lifted(somewhere):
    return lift_landmarks(Scan(somewhere[0]), QUICK)


def test_landmarks_are_lifted_to_the_scan(lifted, somewhere):
    _, truth, T = somewhere
    error = np.linalg.norm(lifted.points - truth, axis=1)[bundled_landmarks().stable] / T.scale
    assert np.nanmedian(error) < 2.5
    assert np.isfinite(error).mean() > 0.95


def test_unit_place_and_winding_are_recognised(lifted, somewhere):
    _, _, T = somewhere
    assert lifted.unit == "cm"
    assert lifted.inside_out
    np.testing.assert_allclose(lifted.T_face_scan.scale, 10)
    turned = (lifted.T_face_scan @ T).rotation
    assert np.degrees(np.arccos((np.trace(turned) - 1) / 2)) < 6
    assert lifted.misfit < 6
    assert set(lifted.scores) == set(load_face().rig.names)


def test_a_noisy_scan_shows_its_face_as_a_clean_one_does():
    mesh = replace(somebody(), colors=None)
    noise = np.random.default_rng(0).normal(0, 2.5, mesh.vertices.shape)
    found = lift_landmarks(Scan(mesh.with_vertices(mesh.vertices + noise)), QUICK)
    truth = bundled_landmarks().attachment.points(mesh)
    error = np.linalg.norm(found.points - truth, axis=1)[bundled_landmarks().stable]
    assert np.nanmedian(error) < 4  # as drawn with its noise 8
