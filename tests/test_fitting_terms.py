"""Each term's Jacobian against differences of its residual, and its residual by hand."""

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.fitting.morphable import FaceState, MorphableModel, identity_model
from mien.fitting.terms import (
    MarkerTerm,
    closest_below,
    fading,
    landmark_term,
    ray_term,
    scheduled,
    surface_points,
    surface_term,
)
from mien.mesh import Attachment, Mesh
from mien.register import Rejection, Surface
from mien.transforms import Transform, rotation_from_vector

NEVER = 1e9
"""A fade so far off that weights do not change."""


def square(height: float = 0.0, size: float = 500.0) -> Mesh:
    """A large square at one height, z up: its closest points lie straight below."""
    x = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * size
    return Mesh(x + np.array([0, 0, height]), np.array([[0, 1, 2], [0, 2, 3]]))


@pytest.fixture(scope="module")
def model() -> MorphableModel:
    return identity_model(load_face())


@pytest.fixture(scope="module")
def state(model) -> FaceState:
    rng = np.random.default_rng(1)
    T = Transform(rotation_from_vector(np.array([0.1, -0.2, 0.05])), np.array([3.0, -4, 5]))
    return FaceState(0.5 * rng.normal(size=len(model.modes)), T, 2.0)


@pytest.fixture(scope="module")
def spots() -> Attachment:
    face = load_face()
    region = np.flatnonzero((face.regions["face"] > 0.9)[face.rig.neutral.faces].all(axis=1))
    return Attachment(region[::40], np.full((len(region[::40]), 3), 1 / 3))


def terms(model, state, spots):
    """Markers lie where the model has them: their metric turns with the skin, and is held within a step."""
    there = surface_points(Mesh(model.vertices(state.coefficients), model.faces), spots, state.standoff)
    rng = np.random.default_rng(2)
    k = len(spots.faces)
    goals, weights = rng.normal(scale=50, size=(k, 3)), rng.uniform(0.5, 1, size=k)
    trust = load_face().regions["face"]
    loose = Rejection(max_angle_deg=180.0, boundary=False)
    return {
        "surface": surface_term(model, Surface(square(-90)), trust, rejection=loose, fade=NEVER),
        "landmarks": landmark_term(model, spots, goals, weights, fade=NEVER),
        "rays": ray_term(model, spots, goals, goals + np.array([0, 0, 400]), weights, fade=NEVER),
        "markers": MarkerTerm(state.T_target_model.apply(there), np.arange(10), attachment=spots, weights=weights),
    }


@pytest.mark.parametrize("name", ["surface", "landmarks", "rays", "markers"])
def test_derivative_of_each_term(model, state, spots, name):
    """Along a random step of turn, shift, coefficients and stand-off. (Markers: skin normals are held in a step.)"""
    term = terms(model, state, spots)[name]
    step = np.random.default_rng(3).normal(size=7 + len(model.modes))
    step[:3] *= 0.01
    step[6:-1] *= 0.0 if name == "markers" else 0.1
    h = 1e-4
    ahead, behind = (term.rows(model, state.moved(s * h * step, model), 0).residual for s in (1, -1))
    slope = term.rows(model, state, 0).jacobian @ step
    # the surface's closest points slide on a plane, so that its distances are exact at any step
    np.testing.assert_allclose((behind - ahead) / (2 * h), slope, rtol=1e-4, atol=1e-4 * np.abs(slope).max())


def test_markers_follow_coefficients(model, state, spots):
    """At no stand-off a marker rides on its point of the skin, whatever the normal does."""
    term = terms(model, state, spots)["markers"]
    flat = FaceState(state.coefficients, state.T_target_model, 0.0)
    rows = term.rows(model, flat, 0)
    landmarks = landmark_term(model, spots, term.cloud, np.ones(len(spots.faces)), fade=NEVER)
    moved = rows.jacobian[:, 6:-1].reshape(len(spots.faces), 3, -1)
    shapes = landmarks.points.jacobian(flat, landmarks.points.placed(flat))[:, :, 6:-1]
    ratio = np.linalg.norm(moved, axis=(1, 2)) / np.linalg.norm(shapes, axis=(1, 2)) / np.sqrt(term.weights)
    assert ratio.max() <= 1 / term.noise_mm + 1e-9
    assert ratio.min() >= 1 / np.hypot(term.noise_mm, 12.0) - 1e-9


def test_a_surface_is_measured_across_and_a_ray_sideways(model, state, spots):
    still = FaceState(np.zeros(len(model.modes)), Transform.identity())
    surface = terms(model, state, spots)["surface"]
    across = surface.rows(model, still, 0).residual / np.sqrt(surface.share) * surface.sigma[0]
    np.testing.assert_allclose(across, -90 - model.mean[surface.which, 2])
    points = spots.points(load_face().rig.neutral)
    behind = points + np.array([3.0, 0, 0]) - np.array([0, 0, 400.0])
    rays = ray_term(model, spots, behind, np.tile([0.0, 0, 2], (len(points), 1)), np.ones(len(points)), fade=NEVER)
    offsets = rays.rows(model, still, 0).residual.reshape(-1, 3) * rays.sigma
    np.testing.assert_allclose(offsets, np.tile([3.0, 0, 0], (len(points), 1)), atol=1e-9)


def test_markers_are_lifted_off_the_skin_and_found_below(spots):
    mesh = load_face().rig.neutral
    lifted = surface_points(mesh, spots, 4.0)
    np.testing.assert_allclose(np.linalg.norm(lifted - spots.points(mesh), axis=1), 4.0)
    below = closest_below(mesh, np.arange(len(mesh.faces)), lifted, 4.0)
    away = np.linalg.norm(below.points(mesh) - spots.points(mesh), axis=1)
    assert np.median(away) < 0.2


def test_far_off_measurements_fade_and_schedules_end_on_their_last_value():
    np.testing.assert_allclose(fading(np.array([0.0, 2.0, 1e6]), 2.0), [1, 0.25, 0], atol=1e-9)
    assert [scheduled((8.0, 4.0), i) for i in range(3)] == [8, 4, 4]
