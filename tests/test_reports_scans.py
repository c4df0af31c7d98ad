"""What is stored of registered scans."""

import json

import numpy as np

from mien.reports import scans
from mien.reports.scans import scans_record, scans_report, surface_distances, worst_regions
from mien.scans.correspond.fine_scale import FineResult
from mien.scans.left_out import LeftOut
from mien.scans.marker_registration import MarkersOnScan, MarkersOnScans
from mien.scans.pipeline import RegisteredScans, ScansConfig
from mien.scans.placed_scans import PlacedScan
from mien.scans.scan_template import FINE_REGIONS, ScanTemplate
from mien.transforms import Transform
from small_scans import markers_on, plain_template, sheet, small_rig


def template() -> ScanTemplate:
    """The sheet, whose left half is the open face."""
    plain = plain_template(sheet())
    values = vars(plain) | {"regions": {"face": (sheet().vertices[:, 0] < 0).astype(float)}}
    return ScanTemplate(**values)


def registered() -> RegisteredScans:
    """Two scans of the sheet, of which the second was registered 0.2 mm too high."""
    mesh, place, here = sheet(), markers_on(sheet()), Transform.identity()
    placed = tuple(PlacedScan(name, frame, mesh, here, None) for name, frame in (("rest", 4), ("smile", 9)))
    n, covered = len(place.faces), np.ones((2, len(place.faces)), bool)
    covered[1, 3] = False
    on = [MarkersOnScan(here, place, place.points(mesh), np.eye(2)[i], np.zeros(n), 0.1, covered[i]) for i in (0, 1)]
    shapes = np.stack([mesh.vertices, mesh.vertices + np.array([0.0, 0.0, 0.2])])
    bad = np.zeros((2, len(FINE_REGIONS)), bool)
    bad[1, 0] = True
    near = np.zeros((2, len(FINE_REGIONS), 1), np.int64)
    fine = FineResult(shapes, bad * 0.5, bad * 0.9, bad, near, ~bad, np.array([0.0, 0.4]))
    both, out = MarkersOnScans(tuple(on), np.zeros(n)), (LeftOut("wall", "no face"),)
    return RegisteredScans(small_rig(), placed, both, template(), place, covered, shapes, fine, shapes, "mm", out)


def test_distances_are_those_to_the_scan_and_of_the_open_face_alone():
    found = surface_distances(registered())
    face = template().regions["face"] > 0.5
    assert np.nanmax(found[0, face]) < 1e-9
    assert 0.1 < np.nanmean(found[1]) <= 0.2001
    assert np.isnan(found[:, ~face]).all()


def test_the_record_names_what_is_doubtful_and_what_was_left_out():
    found = registered()
    record = json.loads(json.dumps(scans_record(found, surface_distances(found), "take.c3d"), allow_nan=False))
    rest, smile = record["scans"]["rest"], record["scans"]["smile"]
    assert (rest["frame"], rest["unreliable"], rest["markers_not_on_scan"]) == (4, [], [])
    assert smile["unreliable"] == smile["flow_not_converged"] == [FINE_REGIONS[0]]
    assert smile["markers_not_on_scan"] == [found.scan_rig.labels[3]]
    assert (record["take"], record["unit"], record["left_out"]) == ("take.c3d", "mm", {"wall": "no face"})


def test_what_is_doubtful_is_named_first():
    first, second, *_ = worst_regions(registered())
    assert first == (FINE_REGIONS[0].replace("_", " "), "smile", 0.5, True)
    assert not second[3]


def test_the_page_begins_with_its_verdict_and_folds_the_papers_figures(monkeypatch):
    for name in ("registered_sheet", "blend_picture", "region_picture", "curvature_picture"):
        monkeypatch.setattr(scans, name, lambda *_: np.zeros((4, 4, 3), np.uint8))
    found = registered()
    page = scans_report("A take", found, surface_distances(found), ScansConfig(), "Fair.", "<p>moves</p>").html()
    order = ["Fair. 15 of 16 regions", "moves", "The worst regions", "Every scan", "fig. 5"]
    places = [page.index(part) for part in order]
    assert places == sorted(places)
    assert page.index("look at the forehead left of smile") < places[1]
