"""2D features as rows: each term's derivative, and what a shift of all of them says."""

import numpy as np
import pytest

import tracking_stage as stage
from mien.landmarks.on_rig import FEATURES
from mien.tracking.terms.features import feature_term, gap_term, landmark_rows, normal_equations, without_head
from mien.tracking.terms.fit_config import BlendshapeFitConfig

PLAIN = BlendshapeFitConfig(robust_scale_mm=1e9, features=13.8, gaps=2.0)
IDS = np.array(FEATURES)


@pytest.fixture(scope="module")
def scene():
    return stage.moment()


@pytest.mark.parametrize("name", ["feature", "gap"])
def test_landmark_terms_have_the_right_derivative(scene, name):
    """The residual after a small change is the residual before, less the rows times the change."""
    m, T, _, observation = scene
    x, centre = np.full(m.shapes, 0.2), T.apply(m.centre[None])[0]

    def term(x, T):
        if name == "feature":
            return feature_term(m, IDS, observation.rays[IDS], x, T, centre, PLAIN)
        return gap_term(m, observation.rays, x, T, centre, PLAIN)

    rows, right = term(x, T)
    rng = np.random.default_rng(0)
    for _ in range(4):
        z = rng.normal(0, 1e-4, m.shapes + 6)
        _, after = term(x + z[:-6], stage.turned(T, z, centre))
        tolerance = 0.02 if name == "feature" else 0.08
        assert np.abs(right - rows @ z - after).max() < tolerance * np.abs(rows @ z).max()


def test_features_without_the_head_ignore_a_common_shift(scene):
    m, T, _, observation = scene
    centre = T.apply(m.centre[None])[0]
    terms = []
    for shift in (0.0, 0.01):
        rays = observation.rays[IDS] + shift
        terms.append(without_head(*feature_term(m, IDS, rays, np.zeros(m.shapes), T, centre, PLAIN)))
    assert np.abs(terms[0][0][:, -6:]).max() == 0
    assert np.abs(terms[0][1] - terms[1][1]).max() < 0.08 * 0.01 * 600 * np.sqrt(13.8)


def test_landmark_rows_give_the_landmarks_themselves(scene):
    m, T, truth, _ = scene
    _, points = landmark_rows(m, IDS, truth, T, T.translation)
    expected = stage.told(stage.person(), truth, T).points[IDS]
    np.testing.assert_allclose(stage.CAMERA.project(points), expected, atol=1e-9)


def test_normal_equations_add_up(scene):
    m, T, _, observation = scene
    centre = T.apply(m.centre[None])[0]
    one = feature_term(m, IDS, observation.rays[IDS], np.zeros(m.shapes), T, centre, PLAIN)
    A, b = normal_equations([one, one], m.shapes)
    np.testing.assert_allclose(A, 2 * one[0].T @ one[0], rtol=1e-4, atol=1e-3 * np.abs(A).max())
    np.testing.assert_allclose(b, 2 * one[0].T @ one[1], rtol=1e-4, atol=1e-3 * np.abs(b).max())
