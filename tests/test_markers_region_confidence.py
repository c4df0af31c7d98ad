"""How well each region is told."""

import numpy as np

from marker_stage import held
from mien.faces import load_face
from mien.markers.left_out import LeftOutError
from mien.markers.region_confidence import RegionConfidence, region_confidence, regions_line
from mien.mesh import Attachment


def told(marker_mm: np.ndarray, motion_mm: np.ndarray, places: Attachment | None = None) -> dict[str, RegionConfidence]:
    face = load_face()
    left_out = LeftOutError(1.0, 0.5, 0.0, marker_mm, motion_mm)
    found = region_confidence(face.rig, places or held(), face.regions, left_out)
    return {region.name: region for region in found}


def test_an_error_is_booked_where_its_marker_sits():
    """Markers on the subject's left are missed by half, the others by a tenth; who was not seen counts nowhere."""
    left = held().points(load_face().rig.neutral)[:, 0] > 0
    off = np.tile(np.where(left, 1.0, 0.2), (3, 1))
    off[0] = np.nan
    found = told(off, np.full((3, 60), 2.0))
    for part in ("forehead", "eye", "cheek"):
        assert found[f"{part} left"].share > 0.45
        assert found[f"{part} right"].share < 0.15
    assert 0.1 < found["mouth"].share < 0.5


def test_a_region_without_a_marker_is_not_seen_and_one_at_rest_hardly_moves():
    face = load_face()
    upper = held().points(face.rig.neutral)[:, 1] > -20
    places = Attachment(held().faces[upper], held().barycentric[upper])
    found = told(np.full((2, upper.sum()), 0.1), np.full((2, upper.sum()), 0.15), places)
    assert found["chin"].told == "not seen"
    assert found["forehead left"].told == "hardly moves"
    line = regions_line(tuple(found.values()))
    assert "no marker sees" in line
    assert "chin" in line.split("no marker sees")[1]


def test_nothing_is_said_where_nothing_was_tried():
    face = load_face()
    found = region_confidence(face.rig, held(), face.regions, LeftOutError(np.nan, np.nan))
    assert {region.told for region in found if region.markers} == {"not tried"}
    assert regions_line(found) == ""
