"""Flows whose truth is known, symmetries, and the energy."""

from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.flow import FlowConfig, FlowConstraints, optical_flow
from textures import CLEAN, N, Texture, grid, pair, shift, sine


def _errors(found, truth):
    """Endpoint errors where the truth stays inside the image."""
    h, w = truth.shape[:2]
    x, y = grid(h, w)
    x, y = x + truth[..., 0], y + truth[..., 1]
    seen = (x >= 0) & (x <= w - 1) & (y >= 0) & (y <= h - 1)
    return np.linalg.norm(found - truth, axis=-1)[seen]


def _similarity(angle, zoom):
    x, y = grid()
    x, y = x - N / 2, y - N / 2
    c, s = zoom * np.cos(angle), zoom * np.sin(angle)
    return np.stack([c * x - s * y - x, s * x + c * y - y], -1)


@pytest.mark.parametrize("move", [(0.4, -0.3), (2.7, 1.2), (-5.5, 4.25)])
def test_translation_is_exact(move):
    truth = shift(*move)
    result = optical_flow(*pair(Texture(0), truth), config=CLEAN)
    assert _errors(result.flow, truth).mean() < 0.01
    assert np.linalg.norm(result.flow - truth, axis=-1)[12:-12, 12:-12].max() < 0.02
    assert result.converged
    assert np.nanmedian(result.residual) < 0.01


@pytest.mark.parametrize(
    ("truth", "bound"),
    [
        (_similarity(0.06, 1.0), 0.04),
        (_similarity(0.0, 1.06), 0.04),
        (sine(1.5, 60.0), 0.06),
        (sine(3.0, 90.0), 0.08),
    ],
)
def test_smooth_flows(truth, bound):
    result = optical_flow(*pair(Texture(1), truth), config=CLEAN)
    assert _errors(result.flow, truth).mean() < bound


def test_large_displacement():
    truth = shift(23.0, -14.0, 2 * N, 2 * N)
    result = optical_flow(*pair(Texture(2, sigma=2.5, size=320), truth))
    assert _errors(result.flow, truth).mean() < 0.1


def test_change_of_light_is_ignored():
    """Gain and offset that vary over the image: the defaults stay close, brightness alone does not."""
    truth = sine(1.5, 80.0)
    source, target = pair(Texture(3), truth)
    x, y = grid()
    target = (1 + 0.2 * x / N) * target + 0.5 * y / N
    default = optical_flow(source, target).flow
    alone = optical_flow(source, target, config=FlowConfig(brightness=1.0, gradient=0.0)).flow
    assert _errors(default, truth).mean() < 0.1 < _errors(alone, truth).mean()


def test_units_do_not_matter():
    truth = sine(1.5, 80.0)
    source, target = pair(Texture(3), truth)
    flows = [optical_flow(scale * source + 7 * scale, scale * target + 7 * scale).flow for scale in (1.0, 0.02, 255.0)]
    np.testing.assert_allclose(flows[1], flows[0], atol=0.02)
    np.testing.assert_allclose(flows[2], flows[0], atol=0.02)


def test_constant_and_equal_images_give_no_flow():
    flat = np.full((24, 30), 3.7)
    np.testing.assert_array_equal(optical_flow(flat, flat + 1).flow, 0)
    x, y = grid(24, 30)
    image = Texture(4)(x, y)
    np.testing.assert_allclose(optical_flow(image, image).flow, 0, atol=1e-3)


def test_mirror_and_transposition():
    source, target = pair(Texture(5), shift(1.3, -2.1) + sine(1.0, 50.0))
    config = FlowConfig(sweeps=60, inner=3)
    flow = optical_flow(source, target, config=config).flow
    mirrored = optical_flow(source[:, ::-1], target[:, ::-1], config=config).flow[:, ::-1] * [-1, 1]
    turned = optical_flow(source.T, target.T, config=config).flow.transpose(1, 0, 2)[..., ::-1]
    np.testing.assert_allclose(mirrored, flow, atol=0.02)
    np.testing.assert_allclose(turned, flow, atol=0.02)


def test_odd_sizes_and_wide_images():
    truth = shift(1.5, -0.8, 41, 133)
    result = optical_flow(*pair(Texture(6), truth), config=CLEAN)
    assert result.flow.shape == (41, 133, 2)
    assert _errors(result.flow, truth).mean() < 0.02


def test_channels_that_complete_each_other_beat_one():
    """Stripes show motion across them alone; two channels with crossed stripes show all of it."""
    truth = sine(1.5, 80.0) + np.array([0.7, -0.4])
    waves = [lambda x, y: np.sin(0.5 * x + 0.3), lambda x, y: np.sin(0.45 * y)]
    pairs = [pair(wave, truth) for wave in waves]
    alone = [_errors(optical_flow(*pair).flow, truth).mean() for pair in pairs]
    stacked = [np.stack(images, -1) for images in zip(*pairs, strict=True)]
    both = _errors(optical_flow(stacked[0], stacked[1]).flow, truth).mean()
    assert both < 0.1
    assert both < 0.2 * min(alone)


def test_a_wrong_channel_is_outvoted():
    """Each channel has its own penaliser: one that shows something else does not spoil two that agree."""
    truth = sine(1.5, 80.0)
    pairs = [pair(Texture(seed), truth) for seed in (7, 8)]
    x, y = grid()
    other = np.where(Texture(9)(x, y) > 1, 1.0, 0.0), np.zeros((N, N))
    good = optical_flow(*(np.stack(i, -1) for i in zip(*pairs, strict=True))).flow
    spoiled = optical_flow(*(np.stack(i, -1) for i in zip(*pairs, other, strict=True))).flow
    assert _errors(spoiled, truth).mean() < 2 * _errors(good, truth).mean() + 0.02


def test_masked_pixels_count_for_nothing():
    truth = shift(1.5, 0.5)
    source, target = pair(Texture(10), truth)
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
    truth = shift(1.5, 0.5)
    source, target = pair(Texture(10), truth)
    target[40:55, 40:60] = np.nan
    result = optical_flow(source, target)
    assert np.isfinite(result.flow).all()
    assert _errors(result.flow, truth).mean() < 0.05


def test_only_the_box_of_the_mask_is_solved():
    truth = shift(1.5, 0.5, 64, 400)
    source, target = pair(Texture(11), truth)
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
    x, y = grid()

    def feature(cx, cy):
        return np.exp(-((x - cx) ** 2 / 18 + (y - cy) ** 2 / 8)) * (1 + 0.3 * (x - cx))

    source, target = feature(25, 40), feature(61, 52)
    place = np.array([[25.0, 40.0]])
    lost = optical_flow(source, target).flow[36:45, 21:30]
    found = optical_flow(source, target, constraints=FlowConstraints(place, place + np.array([36.0, 12.0])))
    assert np.linalg.norm(lost - [36, 12], axis=-1).min() > 5
    assert np.linalg.norm(found.flow[36:45, 21:30] - [36, 12], axis=-1).mean() < 0.3


def test_turned_gradients_beat_plain_constancy_under_rotation():
    truth = _similarity(0.08, 1.0)
    images = pair(Texture(14), truth)
    turned, plain = (optical_flow(*images, config=replace(CLEAN, turn_gradients=turn)).flow for turn in (True, False))
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
