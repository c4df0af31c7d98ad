"""One scan beside its neighbours, laid out."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.image_space.config import FineConfig
from mien.image_space.layout import Layout
from mien.image_space.local_align import UnwrappedScan, compared_with, local_align, prewarped
from mien.mesh import Mesh
from test_scans_correspond_fine_scale import FACES, regions, sheet

RIGHT = np.array([3.0, 0.0])
CONFIG = FineConfig(pixel_mm=2.0)


@pytest.fixture(scope="module")
def layout():
    return Layout(Mesh(sheet(), FACES), regions(), CONFIG.pixel_mm, 1.0)


@pytest.fixture(scope="module")
def scan(layout):
    return UnwrappedScan(layout, sheet(), None, CONFIG)


def test_a_scan_that_has_not_moved_is_itself(layout, scan):
    np.testing.assert_array_equal(scan.vertices(), sheet())
    there = sheet()[layout.vertices[::50]]
    np.testing.assert_allclose(scan.pixels(there), layout.home[::50], atol=1e-4)
    np.testing.assert_allclose(scan.transported(there, layout.home + RIGHT), layout.home[::50] + RIGHT, atol=0.3)
    with pytest.raises(BadInput, match="off the scan's face"):
        scan.pixels(there + 50)


def test_an_earlier_result_is_taken_up(layout):
    again = UnwrappedScan(layout, sheet(), None, CONFIG)
    slid = sheet(1.0)
    again.resume(slid)
    off = np.linalg.norm(again.vertices() - slid, axis=1)[layout.vertices]
    assert np.median(off) < 0.05
    assert np.abs(again.uv - layout.home).max() > 0.2


def test_a_twin_shows_the_same_at_the_same_place(layout, scan):
    images = prewarped(layout, scan, [scan], lambda one: [d.scaled for d in one.detail])
    known = np.isfinite(images[0, ..., 0])
    assert known.mean() > 0.3
    off = np.abs(images[0, ..., 0] - scan.detail[0].scaled)[known]
    assert np.median(off) < 0.02
    both = compared_with(layout, scan, [scan])
    np.testing.assert_allclose(both.source[0, ..., 0][known], both.target[0, ..., 0][known], atol=0.3)


def test_without_neighbours_or_evidence_nothing_moves(layout, scan):
    nobody = np.zeros((2, 0), np.int64)
    assert local_align(layout, [scan], 0, nobody, CONFIG, ()).all()
    np.testing.assert_array_equal(scan.uv, layout.home)
    blind = replace(CONFIG, curvature=replace(CONFIG.curvature, threshold=1e9))
    smooth = [UnwrappedScan(layout, sheet(), None, blind) for _ in range(2)]
    assert local_align(layout, smooth, 0, np.array([[1], [1]]), blind, ()).all()
    np.testing.assert_allclose(smooth[0].uv, layout.home, atol=1e-9)
