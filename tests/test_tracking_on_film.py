"""The tracker on a staged film: a performer whom no rig knows, MediaPipe's own landmarks, a person's rig made of it."""

from dataclasses import replace
from functools import cache

import numpy as np

from face_model import needs_model
from mien.experiments.tracking_ablation import Remembered
from mien.stage import FilmConfig, film, make_performer, score_vertices
from mien.tracking.model import tracking_model
from mien.tracking.person.personalize import PersonalizeConfig, personalize
from mien.tracking.tracker import step
from mien.tracking.tracker_context import TrackConfig, initial_state, tracker_context
from mien.transforms import Transform

RATE, CALM, FRAMES = 15.0, 6, 22


def acted(names):
    """Calm, then brows up, jaw open and a smile to one side, that come and go."""
    weights, t = np.zeros((FRAMES, len(names))), np.clip(np.arange(FRAMES) - CALM, 0, None) / (FRAMES - CALM)
    for name, most, turns in (("browInnerUp", 0.8, 1), ("jawOpen", 0.5, 2), ("mouthSmileLeft", 0.8, 1)):
        weights[:, names.index(name)] = most * np.sin(np.pi * turns * t) ** 2
    return weights


@cache
def shot():
    """The film, its truth, who looked at it, and the person's model."""
    actor = make_performer(31)
    staged = film(actor, acted(list(actor.names)), RATE, FilmConfig(), seed=31)
    frames = list(staged.take)
    take, eyes = replace(staged.take, frames=lambda: iter(frames)), Remembered()
    personal = personalize(take, eyes, PersonalizeConfig(frames=CALM))
    for frame in frames:
        eyes.detect(frame.color, frame.time)
    return take, staged.truth, eyes, tracking_model(personal.rig, personal.landmarks)


@cache
def tracked(config=TrackConfig()):
    take, _, eyes, model = shot()
    context, results = tracker_context(model, take.camera, config), []
    state = initial_state(context)
    for frame in take:
        state, result = step(context, frame, eyes.detect(frame.color, frame.time), state)
        results.append(result)
    return results


def score(results, final):
    """The final mesh or the blendshape fit against the truth."""
    _, truth, _, model = shot()
    T = [r.T_camera_face for r in results]
    poses = Transform(np.stack([t.rotation for t in T]), np.stack([t.translation for t in T]))

    def vertices(frames):
        some = [results[i] for i in frames]
        return np.stack([model.whole(r.weights, r.vertices) if final else model.whole(r.fitted, r.blend) for r in some])

    return score_vertices(vertices, model.rig.neutral.vertices, poses, truth, frames=np.arange(len(results)))


@needs_model
def test_a_strange_face_and_its_head_are_followed():
    results = tracked()
    assert all(r.tracked for r in results)
    found = score(results, True)
    assert found.ratio < 0.445  # of a frozen face; 0.465 without the picture's say, 1 without a fit
    assert found.ratio_strongest < 0.6
    assert found.rotation.mean() < 0.01


@needs_model
def test_a_calm_face_stays_calm():
    assert score(tracked(), True).expression[:CALM].mean() < 0.06  # mm; 0.10 with MediaPipe's standing errors left in


@needs_model
def test_weights_are_nearer_the_truth_than_none_at_all():
    truth, found = shot()[1].weights, np.stack([r.weights for r in tracked()])
    assert np.abs(found - truth).mean() < 0.82 * truth.mean()  # 0.9 without the picture's say, 1.3 without sparsity
    assert np.corrcoef(found.ravel(), truth.ravel())[0, 1] > 0.85


@needs_model
def test_the_final_mesh_lies_nearer_the_skin_than_the_blendshapes():
    final, fit = score(tracked(), True), score(tracked(), False)
    assert final.surface < 0.975 * fit.surface  # 1.00 without the adaptive space, 0.98 where no correctives are learnt
    assert final.surface < 0.5
