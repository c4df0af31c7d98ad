"""Where a frame's markers start on a scan: stand-off first, all scans together, bad ones by name."""

import numpy as np

from mien.faces import load_face
from mien.mesh import Mesh, submesh, vertex_normals
from mien.register import Surface
from mien.scans import marker_pose
from mien.scans.left_out import LeftOut
from mien.scans.marker_pose import MarkerPose, MarkerPoseConfig, ScannedFrame, find_poses, rigid_fit, starts_by_shape
from mien.transforms import Transform, rotation_from_vector

AWAY = Transform(rotation_from_vector(np.array([0.5, -1.0, 0.3])), np.array([200.0, -50.0, 80.0]))


def front() -> Mesh:
    """The bundled face's front: what a scan shows."""
    neutral = load_face().rig.neutral
    face = load_face().regions["face"] > 0.3
    return submesh(neutral, np.flatnonzero(face[neutral.faces].all(axis=1)))[0]


def above(mesh: Mesh, height: float, count: int = 60) -> np.ndarray:
    """Markers that stand so high above a mesh."""
    chosen = np.random.default_rng(0).choice(len(mesh.vertices), count, replace=False)
    return (mesh.vertices + height * vertex_normals(mesh.vertices, mesh.faces))[chosen]


def off_by(pose: MarkerPose, true: Transform, markers: np.ndarray) -> float:
    return float(np.linalg.norm(pose.T_scan_head.apply(markers) - true.apply(markers), axis=1).mean())


def test_markers_that_stand_off_the_skin_leave_nothing_in_the_right_place():
    mesh = front()
    markers = AWAY.apply(above(mesh, 4.0))
    best, *others = starts_by_shape(markers, Surface(mesh))
    assert off_by(best, AWAY.inverse(), markers) < 1.0
    assert best.misfit < 0.4
    assert abs(best.rise - 4.0) < 0.5
    assert all(other.misfit > best.misfit / MarkerPoseConfig().clear for other in others)


def test_without_the_rise_the_stand_off_stays_in_the_misfit():
    mesh = front()
    markers, nowhere = above(mesh, 3.0), np.zeros(60)
    firm = rigid_fit(markers, Surface(mesh), Transform.identity(), nowhere)
    free = rigid_fit(markers, Surface(mesh), Transform.identity(), nowhere, rise=True)
    assert free.misfit < 0.2 * firm.misfit
    assert firm.rise == 0.0


def test_one_pose_of_the_head_must_serve_all_scans(monkeypatch):
    """The neutral scan alone would take the wrong way; the other scan shows which one it is."""
    mesh = front()
    markers, other = above(mesh, 2.0), AWAY.apply(mesh.vertices)
    frames = [
        ScannedFrame("rest", markers, mesh, Transform.identity()),
        ScannedFrame("other", markers, mesh.with_vertices(other), AWAY.inverse()),
    ]
    turned = Transform(rotation_from_vector(np.array([0.0, 0.0, 1.2])), np.zeros(3))
    wrong, right = MarkerPose(turned, 0.0, 0.1), MarkerPose(Transform.identity(), 2.0, 0.5)
    monkeypatch.setattr(marker_pose, "starts_by_shape", lambda *_: [wrong, right])
    found = find_poses(frames)
    assert off_by(found[0], Transform.identity(), markers) < 0.5
    assert off_by(found[1], AWAY, markers) < 0.5


def test_two_ways_that_fit_alike_leave_a_scan_out_where_nothing_else_tells(monkeypatch):
    mesh = front()
    markers = above(mesh, 2.0)
    ways = [MarkerPose(Transform.identity(), 0.0, 0.5), MarkerPose(AWAY, 0.0, 0.6)]
    monkeypatch.setattr(marker_pose, "starts_by_shape", lambda *_: ways)
    (found,) = find_poses([ScannedFrame("ball", markers, mesh, None)])
    assert isinstance(found, LeftOut)
    assert "in two ways (0.5 and 0.6 mm)" in found.why
