"""Pose and identity of a person from their scan and the lines of sight to their landmarks."""

import numpy as np

import tracking_stage as stage
from mien.faces.bundled import load_face
from mien.fitting.morphable import identity_model
from mien.fitting.neutral import fit_identity_to_scan
from mien.fitting.template_parts import TemplateParts
from mien.mesh import submesh
from mien.register.correspond import Surface
from mien.transforms import Transform, rotation_from_vector

MOVED = Transform(rotation_from_vector(np.array([0.03, -0.04, 0.02])), np.array([3.0, -2.0, 4.0]))


def test_a_known_person_is_found_and_depth_of_landmarks_does_not_matter():
    face, rig, landmarks = load_face(), stage.person(5), stage.landmarks()
    front = (face.regions["face"] > 0.2)[rig.neutral.faces].all(axis=1)
    scan, _ = submesh(rig.neutral, np.flatnonzero(front))
    scan = scan.with_vertices(MOVED.apply(scan.vertices))
    eye = np.array([0.0, 0.0, 600.0])
    seen = MOVED.apply(landmarks.attachment.points(rig.neutral))
    seen = eye + (seen - eye) * np.random.default_rng(0).uniform(0.97, 1.03, (478, 1))
    model, trust = identity_model(face), TemplateParts(face).trusted(off_face=0.0)
    found = fit_identity_to_scan(model, landmarks, Surface(scan), seen, eye, trust)
    used = face.regions["face"] > 0.5
    off = np.linalg.norm(found.vertices - rig.neutral.vertices, axis=1)[used]
    average = np.linalg.norm(face.rig.neutral.vertices - rig.neutral.vertices, axis=1)[used]
    assert off.mean() < 0.4 * average.mean()
    points = rig.neutral.vertices[used]
    placed = found.state.T_target_model.apply(points) - MOVED.apply(points)
    assert np.linalg.norm(placed, axis=1).mean() < 2.0
