"""The model on a scan of somebody unknown."""

from dataclasses import replace

import numpy as np
import pytest

from mien.faces.bundled import load_face
from mien.fitting.model_fit import ModelFitConfig, fit_person_to_scan, landmark_anchors
from mien.fitting.template_parts import TemplateParts
from mien.landmarks.detector import COUNT, bundled_landmarks
from mien.mesh import Mesh, submesh
from mien.register import Surface
from mien.transforms import Transform, rotation_from_vector

QUICK = ModelFitConfig(surface_sigma=(8.0, 2.0, 0.8), steps=2)


@pytest.fixture(scope="module")
def scanned():
    """A person with an open mouth and one eye closed: neutral, truth, the skin as a surface."""
    face = load_face()
    person = face.person(0.8 * np.random.default_rng(8).normal(size=30))
    weights = np.zeros(len(person.names))
    for name, weight in {"jawOpen": 0.7, "eyeBlinkLeft": 0.9, "mouthFunnel": 0.3}.items():
        weights[person.index(name)] = weight
    truth = person.vertices(weights)
    on_skin = np.isin(face.rig.neutral.faces, face.parts["skin"]).all(axis=1)
    skin, _ = submesh(Mesh(truth, face.rig.neutral.faces), on_skin)
    T = Transform(rotation_from_vector(np.array([0.03, -0.02, 0.01])), np.array([2.0, -1, 1]))
    return person.neutral.vertices, truth, Surface(skin.with_vertices(T.apply(skin.vertices))), T


def anchors_of(truth: np.ndarray, T: Transform):
    mesh = Mesh(truth, load_face().rig.neutral.faces)
    points = T.apply(bundled_landmarks().attachment.points(mesh))
    return landmark_anchors(points + np.random.default_rng(1).normal(scale=1.0, size=points.shape), np.ones(COUNT))


@pytest.fixture(scope="module")
def parts():
    return TemplateParts(load_face())


def mouth_error(vertices: np.ndarray, truth: np.ndarray) -> float:
    lips = np.concatenate([edge for name, edge in load_face().contours.items() if "lip" in name])
    return float(np.linalg.norm(vertices - truth, axis=1)[lips].mean())


def test_scores_that_were_seen_help_to_find_the_expression(scanned, parts):
    _, truth, surface, T = scanned
    scores = {"jawOpen": 0.7, "eyeBlinkLeft": 0.9, "mouthFunnel": 0.3}
    told = fit_person_to_scan(load_face(), parts, surface, anchors_of(truth, T), scores, QUICK)
    deaf = replace(QUICK, score_share=0.0)
    untold = fit_person_to_scan(load_face(), parts, surface, anchors_of(truth, T), scores, deaf)
    assert told.expression["eyeBlinkLeft"] > 0.5
    assert told.expression["eyeBlinkRight"] < 0.3
    assert abs(told.expression["jawOpen"] - 0.7) < 0.9 * abs(untold.expression["jawOpen"] - 0.7)
    assert mouth_error(told.vertices, truth) < mouth_error(untold.vertices, truth)


def test_landmarks_that_were_not_seen_or_slide_do_not_count():
    points = np.zeros((COUNT, 3))
    points[5] = np.nan
    spread = np.zeros(COUNT)
    spread[4] = ModelFitConfig.landmark_agreement
    anchors = landmark_anchors(points, spread)
    assert anchors.weights[5] == 0
    assert anchors.weights[4] == pytest.approx(0.5)
    groups = bundled_landmarks().groups
    assert not anchors.weights[np.concatenate([groups["contour"], groups["iris_left"]])].any()
    assert np.isfinite(anchors.points).all()


def test_lips_and_lids_are_told_apart(parts):
    face = load_face()
    for value, (upper, lower) in enumerate([("upper_lip", "lower_lip"), ("left_upper_lid", "left_lower_lid")], 1):
        ends = slice(4, -4)
        assert (parts.sides[face.contours[upper][ends]] == value).all()
        assert (parts.sides[face.contours[lower][ends]] == -value).all()
    assert not parts.sides[face.parts["left_eye"]].any()
