"""Flows whose truth is known, symmetries, and the energy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from mien.errors import BadInput
from mien.flow import FlowConfig, FlowConstraints, Level, optical_flow, warp
from mien.flow.checkerboard import framed, unpack
from mien.flow.system import LevelSystem

N = 96
CLEAN = FlowConfig(brightness=1.0, smoothness=0.5, presmooth=0.3, warps=10, tolerance=0.002)
"""For images without noise and change of light."""


class Texture:
    """Smooth noise that can be read anywhere: order-5 splines over periodic noise."""

    def __init__(self, seed, sigma=2.0, size=160):
        noise = np.random.default_rng(seed).standard_normal((size, size))
        noise = ndimage.gaussian_filter(noise, sigma, mode="wrap") + ndimage.gaussian_filter(
            noise, 4 * sigma, mode="wrap"
        )
        self.spline = ndimage.spline_filter(noise / noise.std(), 5, mode="grid-wrap")

    def __call__(self, x, y):
        return ndimage.map_coordinates(self.spline, [y + 32, x + 32], order=5, prefilter=False, mode="grid-wrap")


def _grid(h=N, w=N):
    y, x = np.mgrid[:h, :w].astype(float)
    return x, y


def _pair(texture, flow):
    """Source and target with target(p + flow(p)) = source(p)."""
    x, y = _grid(*flow.shape[:2])
    return texture(x + flow[..., 0], y + flow[..., 1]), texture(x, y)


def _errors(found, truth):
    """Endpoint errors where the truth stays inside the image."""
    h, w = truth.shape[:2]
    x, y = _grid(h, w)
    x, y = x + truth[..., 0], y + truth[..., 1]
    seen = (x >= 0) & (x <= w - 1) & (y >= 0) & (y <= h - 1)
    return np.linalg.norm(found - truth, axis=-1)[seen]


def _sine(amplitude, length):
    x, y = _grid()
    u = amplitude * np.sin(2 * np.pi * y / length)
    return np.stack([u, amplitude * np.sin(2 * np.pi * x / length)], -1)


def _similarity(angle, zoom):
    x, y = _grid()
    x, y = x - N / 2, y - N / 2
    c, s = zoom * np.cos(angle), zoom * np.sin(angle)
    return np.stack([c * x - s * y - x, s * x + c * y - y], -1)


def _shift(dx, dy, h=N, w=N):
    return np.broadcast_to(np.array([dx, dy], float), (h, w, 2))


@pytest.mark.parametrize("move", [(0.4, -0.3), (2.7, 1.2), (-5.5, 4.25)])
def test_translation_is_exact(move):
    truth = _shift(*move)
    result = optical_flow(*_pair(Texture(0), truth), config=CLEAN)
    assert _errors(result.flow, truth).mean() < 0.01
    assert np.linalg.norm(result.flow - truth, axis=-1)[12:-12, 12:-12].max() < 0.02
    assert result.converged
    assert np.nanmedian(result.residual) < 0.01


@pytest.mark.parametrize(
    ("truth", "bound"),
    [
        (_similarity(0.06, 1.0), 0.04),
        (_similarity(0.0, 1.06), 0.04),
        (_sine(1.5, 60.0), 0.06),
        (_sine(3.0, 90.0), 0.08),
    ],
)
def test_smooth_flows(truth, bound):
    result = optical_flow(*_pair(Texture(1), truth), config=CLEAN)
    assert _errors(result.flow, truth).mean() < bound


def test_large_displacement():
    truth = _shift(23.0, -14.0, 2 * N, 2 * N)
    result = optical_flow(*_pair(Texture(2, sigma=2.5, size=320), truth))
    assert _errors(result.flow, truth).mean() < 0.1


def test_change_of_light_is_ignored():
    """Gain and offset that vary over the image: the defaults stay close, brightness alone does not."""
    truth = _sine(1.5, 80.0)
    source, target = _pair(Texture(3), truth)
    x, y = _grid()
    target = (1 + 0.2 * x / N) * target + 0.5 * y / N
    default = optical_flow(source, target).flow
    alone = optical_flow(source, target, config=FlowConfig(brightness=1.0, gradient=0.0)).flow
    assert _errors(default, truth).mean() < 0.1 < _errors(alone, truth).mean()


def test_units_do_not_matter():
    truth = _sine(1.5, 80.0)
    source, target = _pair(Texture(3), truth)
    flows = [optical_flow(scale * source + 7 * scale, scale * target + 7 * scale).flow for scale in (1.0, 0.02, 255.0)]
    np.testing.assert_allclose(flows[1], flows[0], atol=0.02)
    np.testing.assert_allclose(flows[2], flows[0], atol=0.02)


def test_constant_and_equal_images_give_no_flow():
    flat = np.full((24, 30), 3.7)
    np.testing.assert_array_equal(optical_flow(flat, flat + 1).flow, 0)
    x, y = _grid(24, 30)
    image = Texture(4)(x, y)
    np.testing.assert_allclose(optical_flow(image, image).flow, 0, atol=1e-3)


def test_mirror_and_transposition():
    source, target = _pair(Texture(5), _shift(1.3, -2.1) + _sine(1.0, 50.0))
    config = FlowConfig(sweeps=60, inner=3)
    flow = optical_flow(source, target, config=config).flow
    mirrored = optical_flow(source[:, ::-1], target[:, ::-1], config=config).flow[:, ::-1] * [-1, 1]
    turned = optical_flow(source.T, target.T, config=config).flow.transpose(1, 0, 2)[..., ::-1]
    np.testing.assert_allclose(mirrored, flow, atol=0.02)
    np.testing.assert_allclose(turned, flow, atol=0.02)


def test_odd_sizes_and_wide_images():
    truth = _shift(1.5, -0.8, 41, 133)
    result = optical_flow(*_pair(Texture(6), truth), config=CLEAN)
    assert result.flow.shape == (41, 133, 2)
    assert _errors(result.flow, truth).mean() < 0.02


def test_channels_that_complete_each_other_beat_one():
    """Stripes show motion across them alone; two channels with crossed stripes show all of it."""
    truth = _sine(1.5, 80.0) + np.array([0.7, -0.4])
    waves = [lambda x, y: np.sin(0.5 * x + 0.3), lambda x, y: np.sin(0.45 * y)]
    pairs = [_pair(wave, truth) for wave in waves]
    alone = [_errors(optical_flow(*pair).flow, truth).mean() for pair in pairs]
    stacked = [np.stack(images, -1) for images in zip(*pairs, strict=True)]
    both = _errors(optical_flow(stacked[0], stacked[1]).flow, truth).mean()
    assert both < 0.1
    assert both < 0.2 * min(alone)


def test_a_wrong_channel_is_outvoted():
    """Each channel has its own penaliser: one that shows something else does not spoil two that agree."""
    truth = _sine(1.5, 80.0)
    pairs = [_pair(Texture(seed), truth) for seed in (7, 8)]
    x, y = _grid()
    other = np.where(Texture(9)(x, y) > 1, 1.0, 0.0), np.zeros((N, N))
    good = optical_flow(*(np.stack(i, -1) for i in zip(*pairs, strict=True))).flow
    spoiled = optical_flow(*(np.stack(i, -1) for i in zip(*pairs, other, strict=True))).flow
    assert _errors(spoiled, truth).mean() < 2 * _errors(good, truth).mean() + 0.02


def test_masked_pixels_count_for_nothing():
    truth = _shift(1.5, 0.5)
    source, target = _pair(Texture(10), truth)
    mask = np.ones((N, N), bool)
    mask[30:60, 20:50] = False
    clean = optical_flow(source, target, mask=mask)
    spoiled = source.copy()
    spoiled[~mask] = np.random.default_rng(0).standard_normal((~mask).sum()) * 50
    np.testing.assert_array_equal(optical_flow(spoiled, target, mask=mask).flow, clean.flow)
    spoiled[~mask] = np.nan
    np.testing.assert_array_equal(optical_flow(spoiled, target).flow, clean.flow)
    assert _errors(clean.flow, truth).max() < 0.15
    assert np.isnan(clean.residual[~mask]).all()


def test_holes_of_the_target_count_for_nothing():
    truth = _shift(1.5, 0.5)
    source, target = _pair(Texture(10), truth)
    target[40:55, 40:60] = np.nan
    result = optical_flow(source, target)
    assert np.isfinite(result.flow).all()
    assert _errors(result.flow, truth).mean() < 0.05


def test_only_the_box_of_the_mask_is_solved():
    truth = _shift(1.5, 0.5, 64, 400)
    source, target = _pair(Texture(11), truth)
    mask = np.zeros((64, 400), bool)
    mask[10:50, 100:150] = True
    result = optical_flow(source, target, mask=mask, config=FlowConfig(margin=16))
    alone = optical_flow(source[:, 84:166], target[:, 84:166], mask=mask[:, 84:166])
    np.testing.assert_allclose(result.flow[:, 84:166], alone.flow, atol=1e-6)
    assert (result.flow[:, :84] == result.flow[:, 84:85]).all()


def test_constraints_are_met_and_spread():
    """No data at all: the flow goes through the points and takes every value between."""
    flat = np.zeros((40, 60))
    points = np.array([[10.0, 20.0], [50.0, 20.0]])
    moves = np.array([[4.0, 1.0], [-2.0, 3.0]])
    held = FlowConstraints(points, points + moves)
    flow = optical_flow(flat, flat, constraints=held, config=FlowConfig(warps=30, sweeps=40, tolerance=1e-4)).flow
    for (x, y), move in zip(points.astype(int), moves, strict=True):
        np.testing.assert_allclose(flow[y, x], move, atol=0.1)
    assert (np.diff(flow[20, 10:51, 0]) < 1e-3).all()
    assert (np.diff(flow[20, 10:51, 1]) > -1e-3).all()


def test_a_constraint_brings_data_within_reach():
    """A small feature that jumps far: without help it is lost, one point on it brings in the whole of it."""
    x, y = _grid()

    def feature(cx, cy):
        return np.exp(-((x - cx) ** 2 / 18 + (y - cy) ** 2 / 8)) * (1 + 0.3 * (x - cx))

    source, target = feature(25, 40), feature(61, 52)
    place = np.array([[25.0, 40.0]])
    lost = optical_flow(source, target).flow[36:45, 21:30]
    found = optical_flow(source, target, constraints=FlowConstraints(place, place + np.array([36.0, 12.0])))
    assert np.linalg.norm(lost - [36, 12], axis=-1).min() > 5
    assert np.linalg.norm(found.flow[36:45, 21:30] - [36, 12], axis=-1).mean() < 0.3


def _level(rng, h=16, w=20):
    source, target = rng.standard_normal((2, h, w, 2)).astype(np.float32)
    source, target = ndimage.gaussian_filter(source, (2, 2, 0)), ndimage.gaussian_filter(target, (2, 2, 0))
    weight = rng.random((h, w)).astype(np.float32)
    weight[:3], weight[-3:], weight[:, :3], weight[:, -3:] = 0, 0, 0, 0
    return Level(source, target, weight, np.ones_like(weight))


def _system(config, constraints=None):
    rng = np.random.default_rng(8)
    system = LevelSystem(_level(rng), constraints, config)
    flow = ndimage.gaussian_filter(rng.standard_normal((2, 16, 20)), (0, 3, 3)).astype(np.float32) * 3 + 0.3
    return system, flow


HELD = FlowConstraints(np.array([[5.3, 7.8], [12.0, 4.0]]), np.array([[6.0, 8.0], [12.0, 3.0]]))


def test_gradient_of_the_energy():
    """The frozen system at the point of linearisation has the gradient of the true energy."""
    config = FlowConfig(source_share=0.0, turn_gradients=False)
    system, flow = _system(config, HELD)

    def energy(flow):
        u, v = framed(flow[0]), framed(flow[1])
        system.linearise(u, v)
        return system.freeze(u, v)

    energy(flow)
    gradient = _gradient(system, flow)
    rng = np.random.default_rng(1)
    for _ in range(5):
        direction = ndimage.gaussian_filter(rng.standard_normal((2, 16, 20)), (0, 1, 1)).astype(np.float32)
        step = np.float32(2e-3)
        difference = (energy(flow + step * direction) - energy(flow - step * direction)) / (2 * step)
        np.testing.assert_allclose(difference, (gradient * direction).sum(), rtol=2e-2)


def _gradient(system, flow):
    """A w - b of the frozen system, as an image."""
    a11, a12, a22 = (unpack(system.a[:, i]) for i in range(3))
    b1, b2 = (unpack(system.b[:, i]) for i in range(2))
    edges = np.array([unpack(system.edges[:, i]) for i in range(4)])
    wide = np.pad(flow, ((0, 0), (1, 1), (1, 1)), mode="edge")
    around = np.array([wide[:, 1:-1, :-2], wide[:, 1:-1, 2:], wide[:, :-2, 1:-1], wide[:, 2:, 1:-1]])
    smooth = (edges[:, None] * (flow - around)).sum(0)
    return smooth + np.array([a11 * flow[0] + a12 * flow[1] - b1, a12 * flow[0] + a22 * flow[1] - b2])


def test_energy_falls_with_every_sweep():
    for config in (FlowConfig(), FlowConfig(overrelaxation=1.0), FlowConfig(brightness=1.0, overrelaxation=1.95)):
        system, flow = _system(config, HELD)
        u, v = framed(flow[0]), framed(flow[1])
        system.linearise(u, v)
        energies = []
        for _ in range(25):
            energies.append(system.freeze(u, v))
            system.sweep(u, v, 1, config.overrelaxation)
        falls = np.diff(energies)
        assert (falls <= 1e-5 * energies[0]).all()
        assert energies[-1] < 0.9 * energies[0]


def test_energy_falls_in_every_inner_solve():
    result = optical_flow(*_pair(Texture(12), _sine(2.0, 70.0)), config=FlowConfig(inner=4))
    assert len(result.energy) == len(result.iterations) == 4
    for energy, warps in zip(result.energy, result.iterations, strict=True):
        assert energy.shape == (warps, 4)
        assert (np.diff(energy, axis=1) <= 1e-6 * energy[:, :1]).all()
        assert energy[-1, 0] < energy[0, 0]


def test_residual_is_the_difference_of_the_images():
    source, target = _pair(Texture(13), _shift(0.6, 0.2))
    target = target + 0.25
    result = optical_flow(source, target, config=replace(CLEAN, presmooth=0.0, brightness=0.0))
    known = np.abs(warp(target, result.flow) - source)
    np.testing.assert_allclose(result.residual[8:-8, 8:-8], known[8:-8, 8:-8], atol=1e-3)


def test_turned_gradients_beat_plain_constancy_under_rotation():
    truth = _similarity(0.08, 1.0)
    pair = _pair(Texture(14), truth)
    turned, plain = (optical_flow(*pair, config=replace(CLEAN, turn_gradients=turn)).flow for turn in (True, False))
    assert _errors(turned, truth).mean() < 0.5 * _errors(plain, truth).mean()


@pytest.mark.parametrize(
    ("source", "target", "mask", "words"),
    [
        (np.zeros((20, 20)), np.zeros((20, 21)), None, "one shape"),
        (np.zeros((4, 20)), np.zeros((4, 20)), None, "at least 8"),
        (np.zeros((20, 20)), np.zeros((20, 20)), np.zeros((20, 20), bool), "no pixel has data"),
        (np.full((20, 20), np.nan), np.zeros((20, 20)), None, "no pixel has data"),
        (np.zeros((20, 20)), np.full((20, 20), np.nan), None, "no pixel has data"),
    ],
)
def test_bad_input_is_named(source, target, mask, words):
    with pytest.raises(Exception, match=words) as caught:
        optical_flow(source, target, mask=mask)
    assert caught.type is BadInput


def test_bad_settings_are_named():
    for name, value in (("smoothness", 0.0), ("factor", 1.0), ("overrelaxation", 2.0), ("warps", 0)):
        with pytest.raises(BadInput, match=name):
            FlowConfig(**{name: value})
