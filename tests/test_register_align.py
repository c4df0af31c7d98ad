"""Unnamed markers laid on a face."""

import numpy as np

from marker_stage import held, region
from mien.faces import load_face
from mien.fitting.marker_identity import fit_identity, on_closest, person
from mien.fitting.terms import surface_points
from mien.mesh import ClosestPoint, submesh, vertex_normals
from mien.register import procrustes
from mien.register.align import align, starts
from mien.transforms import Transform, rotation_from_vector, vector_from_rotation


def test_starts_are_rotations_that_cover_both_sides_of_every_axis():
    R = np.stack(starts(np.random.default_rng(0).normal(size=(20, 3)) * [3, 2, 1], 12))
    assert R.shape == (72, 3, 3)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-9)


def test_a_persons_markers_are_found_from_any_pose():
    face = load_face()
    there = region()
    places = held()
    rng = np.random.default_rng(7)
    someone = person(face, 0.8 * rng.normal(size=len(face.identity.modes)))
    truth = surface_points(someone, places, 2.5)
    lab = Transform(rotation_from_vector(np.array([2.0, -1.0, 0.5])), np.array([300.0, -200, 900]))
    lifted = face.rig.neutral.vertices + 3 * vertex_normals(face.rig.neutral.vertices, face.rig.neutral.faces)
    surface = ClosestPoint(submesh(face.rig.neutral.with_vertices(lifted), there)[0])
    best = align(lab.apply(truth), surface)[0]
    turn = vector_from_rotation(best.T_face_head.rotation @ lab.rotation)
    assert np.degrees(np.linalg.norm(turn)) < 12
    fit = fit_identity(lab.apply(truth), face, there, best.T_face_head)
    mask = face.regions["face"] > 0.5
    mean = procrustes(face.rig.neutral.vertices[mask], someone.vertices[mask], scale=True).transform
    tree = ClosestPoint(someone)
    before = tree.query(mean.apply(face.rig.neutral.vertices[mask])).distances.mean()
    assert tree.query(fit.neutral.vertices[mask]).distances.mean() < 0.9 * before
    assert fit.residuals.mean() < 0.6
    assert on_closest(fit, lab.apply(truth), there).residuals.max() < 3
