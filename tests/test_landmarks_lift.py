import numpy as np
import pytest

from face_model import needs_model
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.landmarks.lift import LiftConfig, lift_landmarks, similarity_to_average
from mien.mesh import Mesh, Scan, submesh
from mien.transforms import Transform, rotation_from_vector

pytestmark = needs_model
QUICK = LiftConfig(zooms=(), sweep_pixels=256, pixels=400, views=((0.0, 0.0), (-0.25, 0.0), (0.25, 0.0)))


def somebody() -> Mesh:
    coefficients = np.random.default_rng(2).normal(size=20)
    return load_face().person(coefficients).neutral


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


def test_similarity_ignores_a_few_bad_landmarks():
    truth = bundled_landmarks().attachment.points(load_face().rig.neutral)
    T = Transform(rotation_from_vector(np.array([0.2, -0.4, 1.0])), np.array([5.0, 6, 7]), 0.01)
    points = T.apply(truth)
    rng = np.random.default_rng(0)
    points[rng.random(478) < 0.1] += 0.5
    points[rng.random(478) < 0.1] = np.nan
    found, misfit = similarity_to_average(points)
    np.testing.assert_allclose((found @ T).apply(truth), truth, atol=1e-6)
    assert misfit < 1e-6
    assert similarity_to_average(np.full((478, 3), np.nan))[1] == np.inf
