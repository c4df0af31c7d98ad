"""Markers on staged scans: near their true places, nearer after the nonrigid step."""

import numpy as np
import pytest

from marker_stage import held
from mien.faces import load_face
from mien.mesh import Mesh, submesh
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
    nothing = np.zeros((0, *expressions.shape[1:]))
    return fit_markers_to_scans(frames, find_poses(frames), nothing)


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


def nonrigid(expressions, scan: Mesh, shapes, config):
    nowhere = np.zeros(expressions.shape[1])
    return nonrigid_fit(expressions, 0, Surface(scan), Transform.identity(), nowhere, shapes, config)


def test_a_scan_of_another_mix_is_met_by_that_mix_as_far_as_actors_miss():
    """The scan shows a third of the smile on top of rest: eq. 6 finds it; with no slack it stays at what was asked."""
    rig = small_rig()
    expressions, nothing = rig.expressions[:2], np.zeros((0, len(rig.labels), 3))
    scan = Mesh(rig.rig.neutral.vertices + rig.rig.deltas[0] / 3, rig.rig.neutral.faces)
    found = nonrigid(expressions, scan, nothing, MarkerRegistrationConfig(mix_deviation=100.0))
    np.testing.assert_allclose(found.expression_weights, [2 / 3, 1 / 3], atol=0.05)
    held = nonrigid(expressions, scan, nothing, MarkerRegistrationConfig(mix_deviation=1e-4))
    np.testing.assert_allclose(held.expression_weights, [1, 0], atol=1e-3)
    without = nonrigid(expressions, scan, nothing, MarkerRegistrationConfig(mix_deviation=0.0))
    np.testing.assert_array_equal(without.expression_weights, [1, 0])


def test_what_no_other_expression_has_is_told_by_shapes_and_does_not_turn_the_head():
    """At rest was asked for, but the jaw is a little open: the head stays where it is and the markers go along."""
    face, rig = load_face(), load_face().rig
    open_jaw = 0.15 * rig.deltas[rig.index("jawOpen")]
    D = held().matrix(rig.neutral)
    rest, shapes = (D @ rig.neutral.vertices)[None], np.stack([D @ delta for delta in rig.deltas])
    front = np.flatnonzero((face.regions["face"] > 0.01)[rig.neutral.faces].all(axis=1))
    scan = submesh(rig.neutral.with_vertices(rig.neutral.vertices + open_jaw), front)[0]
    turned, off = [], []
    for config in (MarkerRegistrationConfig(), MarkerRegistrationConfig(shape_deviation=0.0)):
        found = nonrigid(rest, scan, shapes, config)
        turned.append(np.linalg.norm(found.T_head_scan.apply(rest[0]) - rest[0], axis=1).mean())
        skin = found.attachment.points(scan)
        off.append(np.linalg.norm(skin - rest[0] - D @ open_jaw, axis=1).mean())
    assert turned[0] < 0.5 * turned[1]
    assert off[0] < 0.5 * off[1]
