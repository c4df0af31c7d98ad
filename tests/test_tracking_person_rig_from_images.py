"""A rig from colour alone, by landmarks that are told exactly."""

from functools import cache

import numpy as np

import tracking_stage as stage
from mien.faces import load_face
from mien.register.rigid import procrustes
from mien.tracking.person.rig_from_images import identity_step, of_usual_size, rig_from_images

TRUE = np.random.default_rng(4).normal(0, 1.2, 8)


@cache
def person():
    return load_face().person(TRUE)


def calm(frames=16):
    return stage.acted(person(), np.zeros((frames, 52)), stage.sway(frames))


@cache
def portrait():
    take, landmarker = calm()
    return rig_from_images(take, landmarker)


def off(vertices):
    """Mean distance from the true face's vertices, by a similarity: colour does not tell size."""
    mask = load_face().regions["face"] > 0.5
    true = person().neutral.vertices[mask]
    laid = procrustes(vertices[mask], true, scale=True).transform.apply(vertices[mask])
    return np.linalg.norm(laid - true, axis=1).mean()


def test_the_person_comes_out_of_the_landmarks():
    found = portrait()
    assert found.fitted < 0.25 * found.average
    assert off(found.rig.neutral.vertices) < 0.4 * off(load_face().rig.neutral.vertices)


def test_the_landmarks_lie_where_they_were_told():
    found, (take, landmarker) = portrait(), calm()
    spots = found.landmarks.attachment.points(found.rig.neutral)
    true = stage.landmarks().attachment.points(person().neutral)
    laid = procrustes(spots, true, scale=True).transform.apply(spots)
    assert np.median(np.linalg.norm((laid - true)[:, :2], axis=1)) < 0.4
    assert found.rig.names == load_face().rig.names
    assert take.count == len(landmarker.answers)


def test_a_step_from_the_truth_stays_there():
    poses, face = stage.sway(6), load_face()
    marks = [stage.told(person(), np.zeros(52), T) for T in poses]
    start = np.zeros(len(face.identity.modes))
    start[: len(TRUE)] = TRUE
    after, away = identity_step(face, stage.landmarks(), start, poses, marks, stage.CAMERA)
    np.testing.assert_allclose(away, 0, atol=1e-9)
    assert np.abs(after - start).max() < 0.35  # the prior pulls a little towards the average
    assert np.linalg.norm(after) < np.linalg.norm(start)


def test_a_picture_says_nothing_of_size_so_it_is_the_usual_one():
    face, marks = load_face(), stage.landmarks()
    usual = of_usual_size(person().neutral.vertices, face, marks)
    for size in (0.8, 1.3):
        np.testing.assert_allclose(of_usual_size(size * person().neutral.vertices, face, marks), usual, atol=1e-6)
    average = face.rig.neutral.vertices
    np.testing.assert_allclose(of_usual_size(0.9 * average, face, marks), average, atol=1e-6)


def test_a_rig_of_pictures_is_of_that_size():
    found = portrait()
    vertices = found.rig.neutral.vertices
    np.testing.assert_allclose(of_usual_size(vertices, load_face(), found.landmarks), vertices, rtol=1e-4, atol=1e-3)
