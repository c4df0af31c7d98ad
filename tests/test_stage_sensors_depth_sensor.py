"""Depth sensors: exact where nothing is wrong, wrong in known ways and amounts where something is."""

from dataclasses import replace

import numpy as np
import pytest

from mien.camera import Camera
from mien.errors import BadInput
from mien.stage.sensors.depth_sensor import DepthSensor, Seen, cut_noise, record, structured_light, time_of_flight

CAMERA = Camera(500.0, 500.0, 159.5, 119.5, 320, 240)
PERFECT = DepthSensor(
    camera=CAMERA, noise=0.0, correlation=0.0, ripple=0.0, disparity_step=0.0, depth_step=0.0, baseline=0.0,
    grazing=0.0, flying=0.0, lost=0.0, dark=0.0,
)  # fmt: skip


def wall(z: float, facing: float = 1.0, brightness: float = 0.8) -> Seen:
    shape = (CAMERA.height, CAMERA.width)
    return Seen(np.full(shape, z), np.full(shape, facing), np.ones(shape, dtype=bool), np.full(shape, brightness))


def rng():
    return np.random.default_rng(0)


def test_a_perfect_sensor_delivers_the_truth():
    np.testing.assert_allclose(record(wall(700.0), PERFECT, rng()), 700.0)


def test_noise_is_as_asked_at_700_mm_and_grows_with_the_square():
    noisy = replace(PERFECT, noise=0.8)
    near, far = (record(wall(z), noisy, rng()).astype(float).std() for z in (700.0, 1400.0))
    np.testing.assert_allclose([near, far], [0.8, 3.2], rtol=0.03)


def test_neighbours_err_alike_where_asked():
    for correlation in (0.0, 1.2):
        grain = cut_noise((480, 640), correlation, rng())
        np.testing.assert_allclose(grain.std(), 1.0, rtol=0.05)
        beside = float((grain[:, 1:] * grain[:, :-1]).mean())
        np.testing.assert_allclose(beside, np.exp(-1 / (4 * correlation**2)) if correlation else 0.0, atol=0.03)


def test_the_usual_pixel_errs_by_about_eight_tenths_of_a_millimetre():
    for sensor in (structured_light(), time_of_flight()):
        seen = wall(700.0, brightness=0.6)
        delivered = record(seen, replace(sensor, camera=CAMERA), rng())
        assert 0.5 < np.abs(delivered[delivered > 0] - 700.0).mean() < 1.0


def test_disparities_come_in_steps():
    stepped = replace(PERFECT, baseline=75.0, disparity_step=0.125)
    depths = np.linspace(650, 700, CAMERA.width)[None].repeat(CAMERA.height, axis=0)
    seen = replace(wall(700.0), depth=depths)
    values = np.unique(record(seen, stepped, rng()))
    steps = 500.0 * 75.0 / values.astype(float) / 0.125
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-2)
    assert np.unique(np.round(steps)).size == len(values) < 40


def test_depth_comes_in_steps():
    values = record(replace(wall(700.0), depth=np.full((240, 320), 700.13)), replace(PERFECT, depth_step=0.25), rng())
    np.testing.assert_array_equal(values, 700.25)


def test_grazing_surfaces_and_shadows_have_holes():
    sensor = replace(PERFECT, grazing=0.2)
    assert (record(wall(700.0, facing=0.15), sensor, rng()) == 0).all()
    assert (record(wall(700.0, facing=0.9), sensor, rng()) > 0).all()
    np.testing.assert_allclose((record(wall(700.0, facing=0.3), sensor, rng()) > 0).mean(), 0.5, atol=0.02)
    dark = replace(wall(700.0), lit=np.zeros((240, 320), dtype=bool))
    assert (record(dark, PERFECT, rng()) == 0).all()


def test_flying_pixels_float_between_near_and_far():
    depth = np.full((240, 320), 700.0)
    depth[:, 160:] = 1400.0
    delivered = record(replace(wall(700.0), depth=depth), replace(PERFECT, flying=0.5), rng())
    between = (delivered > 701) & (delivered < 1399)
    assert 0.3 < between[:, 159:161].mean() < 0.55
    assert not between[:, :159].any()
    assert not between[:, 161:].any()


def test_out_of_range_is_nothing():
    for z in (100.0, 9000.0, np.nan):
        assert (record(wall(z), PERFECT, rng()) == 0).all()


def test_lost_pixels():
    np.testing.assert_allclose((record(wall(700.0), replace(PERFECT, lost=0.1), rng()) == 0).mean(), 0.1, atol=0.01)


def test_pictures_beyond_the_noise_bank_are_refused():
    with pytest.raises(BadInput, match="pixels a side"):
        cut_noise((9000, 10), 0.0, rng())
