"""Scans in one face space, moved with the markers of their frames."""

import numpy as np

from mien.scans.correspond.large_scale import ScanLandmarks
from mien.scans.marker_registration import MarkersOnScan, MarkersOnScans
from mien.scans.placed_scans import PlacedScan, PlacedScans, both_landmarks
from mien.scans.take_in_head import TakeInHead
from mien.transforms import Transform, rotation_from_vector, stacked
from small_scans import markers_on, sheet

TURN = Transform(rotation_from_vector(np.array([0.1, -0.2, 0.05])), np.array([1.0, 2.0, -3.0]))


def test_a_moved_scan_takes_its_markers_landmarks_and_pose_along():
    mesh, place = sheet(), markers_on(sheet())
    seen = ScanLandmarks(np.full((478, 3), np.nan), np.zeros(478))
    scans = tuple(PlacedScan(f"s{i}", i, mesh, Transform.identity(), seen) for i in range(2))
    still, n = Transform.identity(), len(place.faces)
    expressions = np.stack([place.points(mesh)] * 2)
    on = MarkersOnScan(still, place, expressions[0], np.ones(2), np.zeros(n), 0.0, np.ones(n, bool))
    take = TakeInHead(tuple(f"M{i}" for i in range(n)), (), expressions)
    given = PlacedScans(take, MarkersOnScans((on, on), np.zeros(n)), scans, stacked([still, still]))
    moved = given.moved([still, TURN])
    np.testing.assert_allclose(moved.markers[0], expressions[0])
    np.testing.assert_allclose(moved.markers[1], TURN.apply(expressions[1]))
    np.testing.assert_allclose(moved.skin_points[1], TURN.apply(place.points(mesh)), atol=1e-9)
    np.testing.assert_allclose(moved.scans[1].T_face_scan.rotation, TURN.rotation)
    assert both_landmarks(moved.scans[0], moved.scans[1]) is not None
    assert both_landmarks(moved.scans[0], PlacedScan("s", 0, mesh, still, None)) is None
