"""What is stored and said of one registered scan."""

import json

import numpy as np

from mien.faces.bundled import load_face
from mien.fitting.register_scan import RegionError, Registration
from mien.landmarks.lift import Landmarks3D
from mien.mesh import Scan
from mien.reports.single_scan import pose_record, registration_record, registration_report
from mien.transforms import Transform, rotation_from_vector

T = Transform(rotation_from_vector(np.array([0.1, 0.2, 0.3])), np.array([1.0, 2.0, 3.0]), 10.0)


def found() -> Registration:
    """The average face, all of it 0.3 mm off but for an ear that the scan does not show."""
    mesh = load_face().rig.neutral
    nan, n = float("nan"), len(mesh.vertices)
    landmarks = Landmarks3D(np.full((478, 3), nan), np.full(478, nan), T, "cm", {}, misfit=1.5, inside_out=True)
    regions = {"face": RegionError(0.3, 0.5, 0.9), "ears": RegionError(nan, nan, 0.0)}
    distances, smile = np.full(n, 0.3), {"jawOpen": 0.25, "cheekPuff": 0.001}
    return Registration(mesh, T, distances, distances > 0, regions, landmarks, np.zeros(3), smile, ("a hole",))


def test_a_pose_record_leads_back_to_the_pose():
    record = json.loads(json.dumps(pose_record(T)))
    back = Transform(np.array(record["rotation"]), np.array(record["translation_mm"]), record["scale"])
    points = np.eye(3) * 7
    np.testing.assert_allclose(back.apply(points), T.apply(points))


def test_the_record_is_plain_json_without_what_is_no_number():
    record = json.loads(json.dumps(registration_record(found()), allow_nan=False))
    assert record["regions"]["ears"] == {"mean": None, "p95": None, "covered": 0.0}
    assert (record["unreliable"], record["mended"]) == (["ears"], ["a hole"])
    assert record["expression"] == {"jawOpen": 0.25}
    assert (record["unit"], record["inside_out"]) == ("cm", True)


def test_the_page_names_what_is_doubtful():
    one = found()
    scan = Scan(one.mesh.with_vertices(T.inverse().apply(one.mesh.vertices)), name="smile & more")
    page = registration_report(scan, one).html()
    assert "smile &amp; more: a scan in the bundled topology" in page
    assert "Put right in the scan: a hole." in page
    assert "Not reliable, since the scan shows less than half of them: ears." in page
