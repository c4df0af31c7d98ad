"""Two faces laid over each other by their landmarks."""

import numpy as np

import tracking_stage as stage
from mien.landmarks.face_correspondence import match_faces
from mien.landmarks.on_rig import attach_landmarks
from mien.rig.retarget import retarget
from mien.rig.transfer import transfer_deltas
from sheet_rigs import acting, remeshed


def test_a_head_of_another_topology_shows_expression_corrective_and_pose():
    take, (target, landmarks, carried) = acting(), remeshed()
    out = retarget(take, target, match_faces(take.rig, target, (stage.landmarks(), landmarks)))
    assert len(target.neutral.faces) == 9000
    assert (out.dropped, out.correctives) == ((), 1)
    played = out.performance
    np.testing.assert_array_equal(played.T_world_face.rotation, take.T_world_face.rotation)
    np.testing.assert_array_equal(played.T_world_face.translation, take.T_world_face.translation)
    weights = np.array([played.weights[1, played.rig.index(name)] for name in target.names])
    jaw = target.vertices(weights) - target.neutral.vertices
    np.testing.assert_allclose(jaw, 0.5 * target.deltas[target.index("jawOpen")], atol=1e-9)
    # On the bundled topology the transfer is exact; brought over to the other mesh it is what is wanted here.
    bulge = transfer_deltas(take.rig.neutral, take.rig.deltas[-1:], stage.person(7).neutral)[0]
    wanted, found = carried(bulge), played.rig.deltas[-1]
    assert (wanted * found).sum() > 0.96 * np.linalg.norm(wanted) * np.linalg.norm(found)
    largest = np.linalg.norm(wanted, axis=1).max()
    assert np.linalg.norm(found - wanted, axis=1).max() < 0.3 * largest
    neck = target.neutral.vertices[:, 1] < target.neutral.vertices[:, 1].min() + 30
    assert np.linalg.norm(found[neck], axis=1).max() < 0.02 * largest


def test_misplaced_landmarks_do_not_lead_the_match_astray():
    take, (target, landmarks, _) = acting(), remeshed()
    sound = match_faces(take.rig, target, (stage.landmarks(), landmarks))
    points = landmarks.attachment.points(target.neutral)
    points[100:140] -= [0, 0, 180]
    fallen = attach_landmarks(target.neutral, points, np.ones(len(points), bool))
    found = match_faces(take.rig, target, (stage.landmarks(), fallen))
    middles = take.rig.neutral.vertices[take.rig.neutral.faces].mean(1)
    away = np.linalg.norm(middles[found] - middles[sound], axis=1)
    assert np.median(away) < 1.0
    assert np.percentile(away, 90) < 6.0
