"""What one scan shows by itself, and what becomes of one that shows nothing."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces import load_face
from mien.fitting.register_scan import RegisterConfig, Registration
from mien.landmarks.lift import Landmarks3D
from mien.mesh import Mesh, Scan
from mien.scans import fitted_scan
from mien.scans.fitted_scan import FittedScan, fit_scan, fit_template, shapes_at_markers
from mien.scans.left_out import LeftOut
from mien.transforms import Transform, rotation_from_vector
from small_scans import sheet


def fit(unit: str, size: float) -> Registration:
    """A registration that knows its unit, or does not."""
    T = Transform(np.eye(3), np.zeros(3), size)
    seen = Landmarks3D(np.zeros((478, 3)), np.zeros(478), T, unit, {}, 0.0, False)
    n = len(sheet().vertices)
    return Registration(sheet(), T, np.zeros(n), np.ones(n, bool), {}, seen, np.zeros(1), {})


def test_a_scan_without_surface_is_left_out_and_one_without_a_face_goes_on(monkeypatch):
    def refuse(*_, **__):
        raise BadInput("no face found")

    monkeypatch.setattr(fitted_scan, "register_scan", refuse)
    empty = Scan(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)), name="empty")
    assert isinstance(fit_scan(empty, 3, RegisterConfig()), LeftOut)
    plain = fit_scan(Scan(sheet(), name="plain"), 4, RegisterConfig())
    assert isinstance(plain, FittedScan)
    assert (plain.name, plain.frame, plain.fit) == ("plain", 4, None)
    with pytest.raises(BadInput, match="plain: no face found in the neutral scan"):
        fit_template(plain, 0, RegisterConfig())


def test_a_unit_is_the_scan_s_own_where_it_tells_and_the_neutral_s_elsewhere():
    scan = Scan(sheet(), name="s")
    sizes = [FittedScan(scan, 0, sheet(), one).unit_mm(25.4) for one in (fit("cm", 10.0), fit("unknown", 9.3), None)]
    assert sizes == [10.0, 25.4, 25.4]


def test_shapes_move_markers_as_they_move_the_skin_under_them_seen_from_the_head():
    face = load_face()
    rig, some = face.rig, np.arange(0, 600, 25)
    on_average = FittedScan(Scan(sheet(), name="s"), 0, sheet(), replace(fit("mm", 1.0), mesh=rig.neutral))
    T = Transform(rotation_from_vector(np.array([0.3, -0.2, 0.1])), np.array([5.0, -30.0, 60.0]))
    markers = T.inverse().apply(rig.neutral.vertices[some])
    found = shapes_at_markers(on_average, markers, T, face)
    expected = T.inverse().rotate(face.fitted_deltas(rig.neutral.vertices)[:, some])
    skin = np.isin(some, face.parts["skin"])
    assert skin.sum() > 10
    np.testing.assert_allclose(found[:, skin], expected[:, skin], atol=1e-6)
    faceless = replace(on_average, fit=None)
    assert shapes_at_markers(faceless, markers, T, face).shape == (0, len(some), 3)
