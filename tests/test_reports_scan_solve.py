"""The page of a take that was played on scans."""

import numpy as np

from mien.reports.scan_solve import scan_preview, scan_solve_report
from mien.scans.reconstruct import solve_on_scans
from small_scans import gestures, play, small_rig


def test_picture_and_page_say_what_was_solved():
    found, weights = small_rig(), gestures()
    take, _ = play(found, weights)
    positions = take.positions.copy()
    positions[:, 3] = np.nan
    solved = solve_on_scans(take, found)
    picture = scan_preview(solved, count=3, size=60)
    assert picture.ndim == 3
    assert picture.std() > 5
    page = scan_solve_report("take.c3d", solved, found, picture, ["a note & more"]).html()
    assert f"{len(weights)} frames at {take.rate:g} a second on 4 scans" in page
    assert "a note &amp; more" in page
    assert solved.labels[0] in page
