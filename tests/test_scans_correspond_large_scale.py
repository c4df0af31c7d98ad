"""The template on a scan of another expression: eq. 7, between markers and across closed lips."""

from dataclasses import replace

import numpy as np

from mien.faces import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.mesh import Mesh, submesh
from mien.scans.correspond.large_scale import LargeScaleConfig, LargeScaleTarget, ScanLandmarks, register
from small_scans import bundled_template, front_of
from test_fitting_skin_pieces import joined


def smiling() -> np.ndarray:
    rig = load_face().rig
    deltas = sum(0.8 * rig.deltas[rig.index(f"mouthSmile{side}")] for side in ("Left", "Right"))
    return bundled_template().skin.vertices + deltas[bundled_template().members]


def target(goal: np.ndarray, landmarks=None) -> tuple:
    """A scan of the expression with 60 markers: attachment and target."""
    template = bundled_template()
    face = np.flatnonzero((template.regions["face"] > 0.5) & template.shown)
    some = face[:: len(face) // 60]
    attachment = template.attachment_of(template.skin.vertices, template.skin.vertices[some])
    points = attachment.points(template.skin.with_vertices(goal))
    scan = front_of(template.skin.with_vertices(goal))
    return attachment, LargeScaleTarget(scan, points, np.ones(len(points), bool), landmarks)


def test_a_scan_of_an_expression_is_met_between_its_markers():
    template, goal = bundled_template(), smiling()
    shown = (template.regions["face"] > 0.5) & template.shown
    found = register(template, *target(goal))
    assert np.linalg.norm(found - goal, axis=1)[shown].mean() < 0.6
    assert np.linalg.norm(goal - template.skin.vertices, axis=1)[shown].mean() > 2.0


def test_lip_and_lid_landmarks_pull_and_can_be_switched_off():
    template, goal = bundled_template(), smiling()
    seen = np.full((478, 3), np.nan)
    lip = np.flatnonzero(template.sides == 1)[::3][:20]
    where = template.skin.vertices
    group = bundled_landmarks().groups["lips_outer"][: len(lip)]
    before, after = seen.copy(), seen.copy()
    before[group], after[group] = where[lip[: len(group)]], where[lip[: len(group)]] + [0.0, 0.0, 4.0]
    sure = np.zeros(478)
    attachment, scan = target(goal, (ScanLandmarks(before, sure), ScanLandmarks(after, sure)))
    pulled = register(template, attachment, scan, LargeScaleConfig(landmarks=100.0))
    without = register(template, attachment, scan, LargeScaleConfig(landmarks=0.0))
    none = register(template, attachment, replace(scan, landmarks=None))
    np.testing.assert_array_equal(without, none)
    assert np.abs(pulled - without)[lip[: len(group)]].max() > 1.0


def test_lids_keep_off_eyeballs_that_the_scan_shows():
    template = bundled_template()
    attachment, scan = target(wide_eyed())
    eyes = [eye_in_front(name) for name in ("left_eye", "right_eye")]
    beside = replace(scan, mesh=joined(scan.mesh, *eyes))
    found = register(template, attachment, beside)
    np.testing.assert_allclose(found, register(template, attachment, scan), atol=1e-6)


def wide_eyed() -> np.ndarray:
    rig = load_face().rig
    deltas = sum(rig.deltas[rig.index(f"eyeWide{side}")] for side in ("Left", "Right"))
    return bundled_template().skin.vertices + deltas[bundled_template().members]


def eye_in_front(name: str) -> Mesh:
    """What a scan shows of an eyeball between raised lids, hardly behind them."""
    head, members = bundled_template().mesh, bundled_template().parts[name]
    middle = head.vertices[members].mean(axis=0)
    off = head.vertices - middle
    near = (np.abs(off[:, 0]) < 12) & (np.abs(off[:, 1]) < 8) & (off[:, 2] > 0)
    shown = np.isin(np.arange(len(off)), members) & near
    eye = submesh(head, np.flatnonzero(shown[head.faces].all(axis=1)))[0]
    return eye.with_vertices(eye.vertices + np.array([0.0, 0.0, 1.0]))
