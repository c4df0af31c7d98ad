"""From calm depth frames to a person's rig."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import tracking_stage as stage
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.landmarks.face_correspondence import match_faces
from mien.landmarks.on_rig import FEATURES, LandmarkMap, attach_landmarks, skin_faces
from mien.mesh import ClosestPoint, face_normals
from mien.rig.facs import FACS23
from mien.tracking.person.aggregate import AggregateConfig, aggregate
from mien.tracking.person.personalize import PersonalizeConfig, personalize
from mien.transforms import Transform

CALM = 6


@cache
def calm(noise=0.8):
    rig = stage.person(5)
    poses = [stage.pose((0.02 * t, 0.05 * t - 0.1, 0), (t, 0, 0), 500.0) for t in range(CALM)]
    return (*stage.acted(rig, np.zeros((CALM, 52)), poses, noise=noise), poses)


@cache
def made():
    take, landmarker, _ = calm()
    return personalize(take, landmarker, generic=stage.landmarks())


def test_merged_frames_are_closer_to_the_truth_than_any_single_one():
    take, _, poses = calm()
    merged = aggregate(list(take), stage.CAMERA, poses[0])
    truth = ClosestPoint(stage.person(5).neutral)
    assert all(pose is not None for pose in merged.T_camera_face)
    assert truth.query(merged.scan.vertices).distances.mean() < 0.35
    assert (face_normals(merged.scan.vertices, merged.scan.faces)[:, 2] > 0).mean() > 0.9


def test_frames_that_do_not_hold_still_are_refused():
    take, _, poses = calm()
    frames = [replace(f, depth=f.depth + np.float32(40 * i) * (f.depth > 0)) for i, f in enumerate(take)]
    with pytest.raises(BadInput, match="hold still enough"):
        aggregate(frames, stage.CAMERA, poses[0], AggregateConfig(enough=0.5))


def test_no_depth_where_the_face_is():
    take, _, poses = calm()
    empty = [replace(f, depth=np.zeros_like(f.depth)) for f in take]
    with pytest.raises(BadInput, match="no depth where the landmarks see the face"):
        aggregate(empty, stage.CAMERA, poses[0])


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
    take, landmarker, _ = calm()
    config = PersonalizeConfig(frames=2, shapes="facs23")
    assert personalize(take, landmarker, config, generic=stage.landmarks()).rig.names == tuple(FACS23)


def test_without_depth_or_without_a_face_there_is_no_rig():
    take, landmarker, _ = calm()
    with pytest.raises(BadInput, match="has no depth"):
        personalize(replace(take, has_depth=False), landmarker, generic=stage.landmarks())
    nobody = stage.Told(dict.fromkeys(landmarker.answers))
    with pytest.raises(BadInput, match="no face in the first 30 frames"):
        personalize(take, nobody, generic=stage.landmarks())


def test_landmarks_come_back_from_their_file_and_only_for_their_rig(tmp_path):
    person = made()
    person.landmarks.save(tmp_path / "rig.landmarks.json")
    back = LandmarkMap.load(tmp_path / "rig.landmarks.json", person.rig.neutral)
    np.testing.assert_array_equal(back.known, person.landmarks.known)
    mesh, known = person.rig.neutral, person.landmarks.known
    expected = person.landmarks.attachment.points(mesh)[known]
    np.testing.assert_allclose(back.attachment.points(mesh)[known], expected, atol=0.01)
    few = replace(mesh, faces=mesh.faces[:50], uv=None, uv_faces=None)
    with pytest.raises(BadInput, match="written for another rig"):
        LandmarkMap.load(tmp_path / "rig.landmarks.json", few)
    (tmp_path / "bad.json").write_text("[]")
    with pytest.raises(BadInput, match="not a landmark file"):
        LandmarkMap.load(tmp_path / "bad.json", mesh)


def test_lid_landmarks_lie_on_skin_though_eyeballs_are_nearer():
    mesh = load_face().rig.neutral
    points = stage.landmarks().attachment.points(mesh) + np.array([0, 0, 0.2])
    placed = attach_landmarks(mesh, points, np.ones(478, bool))
    assert skin_faces(mesh)[placed.attachment.faces[:468]].all()


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
