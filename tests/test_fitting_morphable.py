"""One Gauss-Newton for all: known faces come back from surfaces, landmarks, rays and markers."""

from dataclasses import replace

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.fitting.morphable import FaceFitConfig, FaceState, fit_face, identity_model, with_expressions
from mien.fitting.terms import MarkerTerm, landmark_term, ray_term, surface_points, surface_term
from mien.landmarks.detector import bundled_landmarks
from mien.mesh import Attachment, Mesh
from mien.register import Surface
from mien.transforms import Transform, rotation_from_vector

T_TARGET_FACE = Transform(rotation_from_vector(np.array([0.05, -0.04, 0.08])), np.array([2.0, -1, 3]))


@pytest.fixture(scope="module")
def somebody():
    """The model, the coefficients of a person, and their face as it is met in the target's frame."""
    model = identity_model(load_face())
    truth = 0.7 * np.random.default_rng(4).normal(size=len(model.modes))
    return model, truth, Mesh(T_TARGET_FACE.apply(model.vertices(truth)), model.faces)


def off(model, fit, met) -> float:
    """Mean distance from where the vertices of the face belong, mm."""
    placed = fit.state.T_target_model.apply(fit.vertices)
    return float(np.linalg.norm(placed - met.vertices, axis=1)[load_face().regions["face"] > 0.5].mean())


def landmarks() -> Attachment:
    found = bundled_landmarks()
    return Attachment(found.attachment.faces[found.stable], found.attachment.barycentric[found.stable])


def test_surface_and_landmarks(somebody):
    model, _, met = somebody
    at = landmarks()
    terms = {
        "surface": surface_term(model, Surface(met), load_face().regions["face"]),
        "landmarks": landmark_term(model, at, at.points(met), np.ones(len(at.faces))),
    }
    fit = fit_face(model, terms)
    assert fit.converged
    assert fit.iterations == FaceFitConfig.rounds
    assert off(model, fit, met) < 0.3
    assert set(fit.costs) == {"surface", "landmarks", "prior"}
    alone = fit_face(model, {"surface": terms["surface"]})
    assert off(model, alone, met) > off(model, fit, met)


def test_rays_of_two_views_and_a_pose_that_is_held(somebody):
    """Two eyes give depth; one gives sides alone, so that along the ray the prior says what is usual."""
    model, _, met = somebody
    at = landmarks()
    seen, n = at.points(met), len(at.faces)
    eyes = np.array([[-200.0, 50, 600], [250.0, -80, 550]])
    held = FaceFitConfig(rounds=6, pose=False)
    start = FaceState(np.zeros(len(model.modes)), T_TARGET_FACE, 3.0)
    terms = {
        str(i): ray_term(model, at, np.tile(eye, (n, 1)), seen - eye, np.ones(n), sigma=0.3)
        for i, eye in enumerate(eyes)
    }
    both = fit_face(model, terms, held, start)
    one = fit_face(model, {"0": terms["0"]}, held, start)
    np.testing.assert_array_equal(both.state.T_target_model.rotation, T_TARGET_FACE.rotation)
    assert off(model, both, met) < 1.0
    assert off(model, both, met) < 0.7 * off(model, one, met)


def test_markers_and_their_stand_off(somebody):
    model, _, met = somebody
    face = load_face()
    region = np.flatnonzero((face.regions["face"] > 0.5)[met.faces].all(axis=1))
    at = Attachment(region[::25], np.full((len(region[::25]), 3), 1 / 3))
    cloud = surface_points(met, at, 4.5)
    given = fit_face(model, {"markers": MarkerTerm(cloud, region, at, noise_mm=0.3, slide_mm=(0.3,))})
    assert abs(given.state.standoff - 4.5) < 0.2
    assert off(model, given, met) < 1.0
    found = fit_face(model, {"markers": MarkerTerm(cloud, region)})
    assert off(model, found, met) < 4.0
    told = FaceFitConfig(standoff_mm=4.5, standoff_deviation_mm=1e-6)
    assert fit_face(model, {"markers": MarkerTerm(cloud, region)}, told).state.standoff == pytest.approx(4.5)


def test_bounds_and_what_is_held(somebody):
    """Weights stay in 0..1; a deviation of 0 holds a coefficient where it is expected."""
    people, _, _ = somebody
    face = load_face()
    jaw = face.rig.deltas[[face.rig.index("jawOpen")]]
    model = with_expressions(people, jaw, np.zeros(1), 10.0)
    met = Mesh(model.mean - 0.7 * jaw[0], model.faces)
    at = landmarks()
    term = {"landmarks": landmark_term(model, at, at.points(met), np.ones(len(at.faces)))}
    assert fit_face(model, term).state.coefficients[-1] == pytest.approx(0.0, abs=1e-9)
    held = replace(model, deviation=np.r_[np.zeros(len(people.modes)), 10.0], expected=np.r_[people.expected, 0.5])
    fit = fit_face(held, term)
    np.testing.assert_array_equal(fit.state.coefficients[:-1], 0)
