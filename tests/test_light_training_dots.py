from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

import light_dots
from mien.light.training.dots import DotConfig, find_dots, pixel_mm

DOTS = DotConfig(radius_mm=light_dots.RADIUS_MM)


@pytest.mark.parametrize("bright", [False, True])
def test_every_dot_is_found_to_a_fraction_of_a_pixel(bright):
    scan = light_dots.scan(dark=5.0 if bright else 0.1)
    found = find_dots(scan, replace(DOTS, bright=bright))
    assert len(found) == len(light_dots.places())
    distance, _ = cKDTree(light_dots.places()).query(found)
    assert distance.max() < 0.35 * pixel_mm(scan)


def test_a_dot_on_which_the_patterns_were_lost_lies_on_the_skin_round_it():
    scan = light_dots.scan()
    lost = np.where((scan.albedo < 0.5)[..., None], np.nan, scan.points)
    found = find_dots(replace(scan, points=lost), DOTS)
    assert len(found) == len(light_dots.places())
    assert cKDTree(light_dots.places()).query(found)[0].max() < 0.7


def test_a_line_is_no_dot_and_nothing_has_none():
    scan = light_dots.scan(dark=1.0)
    albedo = scan.albedo.copy()
    albedo[100:104, 30:130] *= 0.1
    assert len(find_dots(replace(scan, albedo=albedo), DOTS)) <= 2
    assert find_dots(scan, DOTS).shape == (0, 3)
    empty = replace(scan, points=np.full_like(scan.points, np.nan))
    assert find_dots(empty, DOTS).shape == (0, 3)
