"""Markers on staged scans: near their true places, nearer after the nonrigid step."""

import numpy as np
import pytest

from mien.mesh import Mesh
from mien.register import Surface
from mien.scans.marker_pose import ScannedFrame, find_poses
from mien.scans.marker_registration import MarkerRegistrationConfig, fit_markers_to_scans, nonrigid_fit
from mien.takes.preprocess import preprocess_take
from mien.transforms import Transform
from scan_stage import FRAMES, scan_stage
from small_scans import small_rig


@pytest.fixture(scope="module")
def on_scans():
    _, take, _, scans = scan_stage()
    expressions = preprocess_take(take.markers).positions[list(FRAMES)]
    own = [s.truth.T_scan_face.inverse() for s in scans]
    given = zip(scans, expressions, own, strict=True)
    frames = [ScannedFrame(s.scan.name, x, s.scan.mesh, T) for s, x, T in given]
    return fit_markers_to_scans(frames, find_poses(frames))


def test_markers_are_found_on_scans_in_frames_of_their_own(on_scans):
    _, take, layout, scans = scan_stage()
    for staged, found in zip(scans, on_scans.scans, strict=True):
        true = staged.truth.points(layout.attachment)
        off = np.linalg.norm(found.attachment.points(staged.scan.mesh) - true, axis=1)[found.covered]
        assert found.covered.mean() > 0.85
        assert off.mean() < 1.0
    assert abs(np.mean(on_scans.standoff) - take.truth.standoff.mean()) < 0.4


def test_the_nonrigid_step_brings_markers_closer_than_the_rigid_one(on_scans):
    for found in on_scans.scans:
        assert np.sqrt((found.height_residual[found.covered] ** 2).mean()) < found.rigid_rms + 1e-9
        np.testing.assert_allclose(found.expression_weights.sum(), 1.0, atol=1e-9)


def test_a_scan_of_another_mix_is_met_by_that_mix_as_far_as_actors_miss():
    """The scan shows a third of the smile on top of rest: eq. 6 finds it; with no slack it stays at what was asked."""
    rig = small_rig()
    expressions = rig.expressions[:2]
    scan = Surface(Mesh(rig.rig.neutral.vertices + rig.rig.deltas[0] / 3, rig.rig.neutral.faces))
    nowhere = np.zeros(len(rig.labels))
    loose = MarkerRegistrationConfig(performance_sigma=100.0)
    found = nonrigid_fit(expressions, 0, scan, Transform.identity(), nowhere, loose)
    np.testing.assert_allclose(found.expression_weights, [2 / 3, 1 / 3], atol=0.05)
    strict = MarkerRegistrationConfig(performance_sigma=1e-4)
    held = nonrigid_fit(expressions, 0, scan, Transform.identity(), nowhere, strict)
    np.testing.assert_allclose(held.expression_weights, [1, 0], atol=1e-3)
