"""How a cloud lies on a face, and what is worn off it."""

from dataclasses import replace

import numpy as np
import pytest

from marker_stage import held, region
from mien.faces import load_face
from mien.fitting.template_parts import TemplateParts
from mien.markers.lay_on_face import OTHER_WAY_MM, LayConfig, OffFaceConfig, lay_on_face, margin_over, off_face
from mien.mesh import Attachment
from mien.register.align import AlignConfig
from mien.takes.marker_model import marker_model

FRAMES = 30
QUICK = LayConfig(align=AlignConfig(followed=5, most=3), off_face=OffFaceConfig(pulls=(0.7,)))
OFF = [3, 20, 41, 50, 62]
"""Where in the take the markers of a cap stand."""


@pytest.fixture(scope="module")
def capped() -> np.ndarray:
    """Sixty markers on a face that acts, and five of a rigid body above the forehead, among them (head frame)."""
    rng = np.random.default_rng(3)
    face, places = load_face(), held()
    person = face.person(0.7 * rng.normal(size=len(face.identity.modes)))
    model = marker_model(person, places, np.full(60, 3.0))
    weights = np.clip(rng.normal(0, 0.3, (FRAMES, 52)), 0, 1) * np.sin(np.linspace(0, np.pi, FRAMES))[:, None]
    cap = np.array([[0, 150.0, 40], [50, 140, 10], [-45, 160, 0], [20, 190, -20], [-20, 130, 60]])
    moved = np.insert(model.points(weights), np.array(OFF) - np.arange(5), cap, axis=1)
    return moved + rng.normal(0, 0.1, moved.shape)


def test_markers_of_a_cap_are_told_from_the_face(capped):
    laid = lay_on_face(capped, load_face(), region(), config=QUICK)
    assert np.setdiff1d(np.arange(65), laid.kept).tolist() == OFF
    assert laid.shape_mm < 2.5
    up = laid.identity.T_face_head.rotation @ np.array([0.0, 1, 0])
    assert up[1] > 0.9


def test_without_looking_for_them_the_cloud_is_no_face(capped):
    everyone = replace(QUICK, off_face=OffFaceConfig(suspect_mm=np.inf))
    assert lay_on_face(capped, load_face(), region(), config=everyone).shape_mm > 3.5


def test_off_the_face_is_told_by_millimetres_and_by_the_others():
    near, far = np.full(9, 1.0), np.full(9, 4.0)
    assert off_face(np.r_[near, 9.0], OffFaceConfig()).nonzero()[0].tolist() == [9]
    assert not off_face(np.r_[near, 7.0], OffFaceConfig()).any()
    assert not off_face(np.r_[far, 15.0], OffFaceConfig()).any()


def test_an_alignment_that_slides_and_one_the_other_way_round_have_margins_of_their_own():
    squared, apart = np.array([4.0, 4.0, 16.0]), np.array([0.0, 12, 140])
    assert margin_over(squared, apart > 8) == (0.0, 4.0)
    assert margin_over(squared, apart > OTHER_WAY_MM) == (0.5, 16.0)
    assert margin_over(squared, apart > 200) == (1.0, np.inf)


def test_a_calm_frame_that_misleads_is_left_for_another(monkeypatch):
    face, rng, all_places = load_face(), np.random.default_rng(4), held()
    places = Attachment(all_places.faces[:20], all_places.barycentric[:20])
    weights = np.zeros((FRAMES, 52))
    weights[:, face.rig.names.index("jawOpen")] = np.linspace(0, 0.5, FRAMES)
    take = marker_model(face.rig, places, np.full(20, 3.0)).points(weights) + rng.normal(0, 0.1, (FRAMES, 20, 3))
    clouds = {25: take.mean(axis=(0, 1)) + rng.uniform(-70, 70, (20, 3)), 3: take[3]}
    monkeypatch.setattr("mien.markers.lay_on_face.calm_frames", lambda positions: list(clouds))
    monkeypatch.setattr("mien.markers.lay_on_face.mean_cloud", lambda positions, frame: clouds[frame])
    config = replace(QUICK, off_face=OffFaceConfig(suspect_mm=np.inf))
    assert lay_on_face(take, face, region(), config=config).shape_mm < 1
    assert lay_on_face(take, face, region(), config=replace(config, calm=1)).shape_mm > 3


def test_markers_below_the_chin_are_seated_on_the_skin_there_and_no_sign_against_a_face():
    """Beyond the face's region by 20 mm and more: counted from its edge, two of 42 made a face no face."""
    face, everywhere = load_face(), held()
    mesh = face.rig.neutral
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    skin = TemplateParts(face).skin_faces
    below = [skin[np.argmin(np.linalg.norm(centres[skin] - [x, -125, 45], axis=1))] for x in (-12, 12)]
    places = Attachment(np.r_[everywhere.faces[:40], below], np.full((42, 3), 1 / 3))
    weights = np.zeros((FRAMES, 52))
    weights[:, face.rig.names.index("jawOpen")] = np.linspace(0, 0.5, FRAMES)
    take = marker_model(face.rig, places, np.full(42, 2.0)).points(weights)
    laid = lay_on_face(take, face, region(), config=QUICK)
    assert len(laid.kept) == 42
    assert laid.shape_mm < 1.5
    assert not np.isin(laid.identity.attachment.faces[40:], region()).any()
