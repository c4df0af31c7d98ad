"""Scans in one face space, moved with the markers of their frames."""

import numpy as np

from mien.fitting.register_scan import Registration
from mien.landmarks.lift import Landmarks3D
from mien.mesh import Scan
from mien.scans.correspond.large_scale import ScanLandmarks
from mien.scans.fitted_scan import FittedScan
from mien.scans.marker_registration import MarkersOnScan, MarkersOnScans
from mien.scans.placed_scans import PlacedScan, PlacedScans, both_landmarks, scanned_frames
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


def registration(scale: float, unit: str) -> Registration:
    """The sheet as it was found in a file of some unit."""
    mesh, nothing = sheet(), np.zeros(len(sheet().vertices))
    seen = Landmarks3D(
        np.full((478, 3), np.nan), np.zeros(478), Transform.identity(), unit, {}, misfit=0.0, inside_out=False
    )
    T = Transform(np.eye(3), np.zeros(3), scale)
    return Registration(mesh, T, nothing, nothing > 0, {}, seen, np.zeros(2), {})


def test_scans_are_seen_in_millimetres_by_their_own_unit_or_the_neutrals():
    mesh = sheet()
    small = mesh.with_vertices(mesh.vertices / 10)
    known = FittedScan(Scan(small, name="a"), 0, small, registration(10.0, "cm"))
    silent = FittedScan(Scan(small, name="b"), 1, small, None)
    take = TakeInHead(("M",), (known, silent), np.zeros((2, 1, 3)))
    for frame in scanned_frames(take):
        np.testing.assert_allclose(frame.mesh.vertices, mesh.vertices)
    first, second = scanned_frames(take)
    assert second.T_face_scan is None
    np.testing.assert_allclose(first.T_face_scan.apply(mesh.vertices).mean(axis=0), mesh.vertices.mean(axis=0))
