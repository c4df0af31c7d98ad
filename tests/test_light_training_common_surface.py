from dataclasses import replace

import numpy as np
import pytest

import light_dots
import light_scene
from mien.errors import BadInput
from mien.light.training.common_surface import CommonConfig, at_points, common_surface, displacement_map

CONFIG = CommonConfig(grid_mm=1.6, relief_mm=4.0)
RIPPLE = 0.4


@pytest.fixture(scope="module")
def surface():
    return common_surface(light_dots.scan(ripple=RIPPLE), light_dots.places(), CONFIG)


def off(surface, turned, dots):
    """Distances of registered vertices from their true places, where they are seen off the ball's rim."""
    found = surface.register(light_dots.scan(turned, ripple=RIPPLE), light_dots.VIEW, dots)
    middle = np.linalg.norm(surface.mesh.vertices[:, :2], axis=1) < 50
    assert found.seen[middle].mean() > 0.98
    inside = middle & found.seen
    return np.linalg.norm(found.vertices - turned.apply(surface.mesh.vertices), axis=1)[inside]


def test_a_turned_head_is_found_again_point_by_point(surface):
    turned = light_dots.pose((0.05, 0.08, 0.03), (4.0, -2.0, 3.0))
    assert np.median(off(surface, turned, light_dots.places(turned))) < 0.1


def test_flow_on_displacement_maps_mends_what_the_dots_leave(surface):
    slid = light_dots.places(light_dots.pose((0.0, 0.012, 0.0)))
    by_dots = off(replace(surface, config=replace(CONFIG, refine=False)), light_dots.pose(), slid)
    refined = off(surface, light_dots.pose(), slid)
    assert np.median(by_dots) > 0.7
    assert np.median(refined) < 0.5 * np.median(by_dots)


def test_what_a_scan_does_not_show_is_not_seen_and_stays_where_the_dots_say(surface):
    scan = light_dots.scan()
    hole = scan.points.copy()
    hole[60:90, 60:90] = np.nan
    found = surface.register(replace(scan, points=hole), light_dots.VIEW, light_dots.places())
    pixels = light_dots.VIEW.camera.project(surface.mesh.vertices)
    inside = np.all((pixels > 64) & (pixels < 86), axis=1)
    assert inside.any()
    assert not found.seen[inside].any()
    assert np.isfinite(found.vertices).all()
    assert np.isnan(found.albedo[inside]).all()


def test_displacement_maps_show_ripples_and_no_ball(surface):
    smooth = common_surface(light_dots.scan(), light_dots.places(), CONFIG)
    inner = np.zeros(surface.number.shape, bool)
    inner[20:-20, 20:-20] = True
    assert np.nanstd(surface.relief[inner]) > 2 * np.nanstd(smooth.relief[inner])
    nothing = displacement_map(surface, surface.mesh.vertices, np.zeros(len(surface.albedo), bool))
    assert np.isnan(nothing).all()


def test_pictures_are_read_where_the_camera_sees_points():
    columns = np.tile(np.arange(160.0), (200, 1))
    point = np.array([[10.0, 0.0, light_scene.CENTRE[2]]])
    assert at_points(columns, light_dots.VIEW, point)[0] == pytest.approx(light_dots.VIEW.camera.project(point)[0, 0])


def test_too_few_dots_and_no_surface_are_told():
    with pytest.raises(BadInput, match="2 dots"):
        common_surface(light_dots.scan(), light_dots.places()[:2], CONFIG)
