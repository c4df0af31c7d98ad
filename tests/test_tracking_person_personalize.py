"""From calm depth frames to a person's rig."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.landmarks.detector import Landmarks2D
from mien.landmarks.face_correspondence import match_faces
from mien.landmarks.on_rig import FEATURES, LOWER_INNER_LIP
from mien.mesh import ClosestPoint
from mien.rig.facs import FACS23
from mien.tracking.person.aggregate import Aggregate
from mien.tracking.person.personalize import PersonalizeConfig, own_landmarks, personalize
from mien.transforms import Transform


@cache
def made():
    take, landmarker, _ = stage.calm()
    return personalize(take, landmarker, generic=stage.landmarks())


def test_the_person_is_found_to_the_scan_s_detail():
    person, truth = made(), stage.person(5).neutral
    used = load_face().regions["face"] > 0.5
    off = ClosestPoint(truth).query(person.rig.neutral.vertices[used]).distances
    from_average = ClosestPoint(truth).query(load_face().rig.neutral.vertices[used]).distances
    assert off.mean() < 0.6
    assert off.mean() < 0.35 * from_average.mean()
    assert person.neutral.wrapped < person.neutral.fitted


def test_the_person_has_the_expressions_and_their_own_landmarks():
    person = made()
    assert person.rig.names == load_face().rig.names
    smile = person.rig.deltas[person.rig.index("mouthSmileLeft")]
    generic = load_face().rig.deltas[person.rig.index("mouthSmileLeft")]
    assert np.corrcoef(smile.ravel(), generic.ravel())[0, 1] > 0.9
    ids = list(FEATURES)
    truth = stage.landmarks().attachment.points(stage.person(5).neutral)[ids]
    found = person.landmarks.attachment.points(person.rig.neutral)[ids]
    assert np.linalg.norm(found - truth, axis=1).mean() < 2.0


def test_the_paper_s_twenty_three_expressions():
    take, landmarker, _ = stage.calm()
    config = PersonalizeConfig(frames=2, shapes="facs23")
    assert personalize(take, landmarker, config, generic=stage.landmarks()).rig.names == tuple(FACS23)


def test_without_depth_or_without_a_face_there_is_no_rig():
    take, landmarker, _ = stage.calm()
    with pytest.raises(BadInput, match="has no depth"):
        personalize(replace(take, has_depth=False), landmarker, generic=stage.landmarks())
    nobody = stage.Told(dict.fromkeys(landmarker.answers))
    with pytest.raises(BadInput, match="no face in any of its 6 frames"):
        personalize(take, nobody, generic=stage.landmarks())


def test_faces_are_matched_by_their_landmarks():
    """Two people of one topology: the triangle that rules a triangle is itself or beside it."""
    source, target = stage.person(5), stage.person(6)
    bigger = replace(target, neutral=target.neutral.with_vertices(1.2 * target.neutral.vertices + [0, 5, 9]))
    found = match_faces(source, bigger, (stage.landmarks(), stage.landmarks()))
    centres = source.neutral.vertices[source.neutral.faces].mean(1)
    skin = np.flatnonzero(load_face().regions["face"] > 0.9)
    front = np.isin(source.neutral.faces, skin).all(1)
    off = np.linalg.norm(centres[found] - centres, axis=1)[front]
    assert np.median(off) < 3.0


def test_the_scan_is_in_the_person_s_face_space():
    person = made()
    off = ClosestPoint(person.rig.neutral).query(person.scan.vertices).distances
    assert np.median(off) < 0.6
    assert isinstance(person.neutral.T_scan_face, Transform)


def test_landmarks_are_where_they_were_seen_on_this_face_but_for_the_inner_lips():
    """A landmarker that sees a brow and an inner lip 6 mm too high on this person: the brow's place is taken over."""
    rig, generic = stage.person(5), stage.landmarks()
    poses = [stage.pose((0.0, 0.1 * t, 0.0)) for t in (-1, 0, 1)]
    brow, lip = 105, LOWER_INNER_LIP[1]
    found = []
    for T in poses:
        points = T.apply(generic.attachment.points(rig.neutral))
        points[[brow, lip], 1] -= 6.0
        found.append(Landmarks2D(stage.CAMERA.project(points), np.zeros(478), {}))
    scanned = Aggregate(rig.neutral, tuple(poses), 0.0)
    own = own_landmarks(rig, generic, scanned, Transform.identity(), found, stage.CAMERA)
    moved = own.attachment.points(rig.neutral) - generic.attachment.points(rig.neutral)
    assert moved[brow, 1] > 4.0
    assert abs(moved[lip, 1]) < 0.5
