from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.light.decode_phase import (
    bending,
    decode_gray,
    decode_phase,
    evened_phase,
    moving_phase,
    unwrap,
    wrap,
    wrapped_phase,
)
from mien.light.patterns import gray_set, phase_set, profile

H, W = 30, 120
COLUMNS = 20 + 1.7 * np.arange(W)[None] + 0.3 * np.arange(H)[:, None]
ROWS = 10 + 1.1 * np.arange(H)[:, None] + 0.05 * np.arange(W)[None]


def capture(patterns, noise=0.003):
    rng = np.random.default_rng(0)
    images = np.empty((len(patterns), H, W))
    for slot, pattern in enumerate(patterns.patterns):
        place = ROWS if pattern.axis == "y" else COLUMNS
        size = patterns.height if pattern.axis == "y" else patterns.width
        images[slot] = np.interp(place, np.arange(size), profile(pattern, size))
    return 0.05 + 0.7 * images + noise * rng.normal(size=images.shape)


def test_gray_codes_give_both_axes_to_the_pixel_and_smoothed_to_a_part_of_it():
    patterns = gray_set(256, 64)
    images = capture(patterns)
    for axis, truth in (("x", COLUMNS), ("y", ROWS)):
        whole = decode_gray(images, patterns, axis, smooth=False)
        assert np.abs(whole.pixel - truth)[whole.known].max() < 1.0
        fine = decode_gray(images, patterns, axis)
        assert np.abs(fine.pixel - truth)[fine.known].mean() < 0.5 * np.abs(whole.pixel - truth)[whole.known].mean()


def test_a_phase_shift_unwrapped_by_its_code_is_sub_pixel():
    patterns = phase_set(256, 64, 4, 32.0)
    decoded = decode_phase(capture(patterns), patterns)
    assert decoded.known.mean() > 0.9
    assert np.abs(decoded.pixel - COLUMNS)[decoded.known].mean() < 0.1


@pytest.mark.parametrize("steps", [3, 4, 7])
def test_any_number_of_steps_gives_the_phase(steps):
    angle = np.linspace(-3, 3, 50)[None]
    phases = 2 * np.pi * np.arange(steps) / steps
    images = np.stack([0.4 + 0.3 * np.cos(angle + p) for p in phases])
    phase, swing = wrapped_phase(images, phases)
    np.testing.assert_allclose(phase, angle, atol=1e-9)
    np.testing.assert_allclose(swing, 0.3)
    with pytest.raises(BadInput, match="3 or more"):
        wrapped_phase(images[:2], phases[:2])


@pytest.mark.parametrize(("steps", "at_most"), [(3, 0.1), (4, 0.03), (5, 0.03)])
def test_a_plane_that_moves_leaves_few_waves_in_two_rounds_of_steps(steps, at_most):
    start = np.linspace(0, 6 * np.pi, 400)[None]
    phases = 2 * np.pi / steps * np.tile(np.arange(steps), 2)
    speed = 0.05
    images = np.stack([0.4 + 0.3 * np.cos(start + speed * k + p) for k, p in enumerate(phases)])

    def waves(found, slots):
        off = wrap(found - start - speed * (slots - 1) / 2)
        return (off - off.mean()).std()

    once = waves(wrapped_phase(images[:steps], phases[:steps])[0], steps)
    plain = waves(wrapped_phase(images, phases)[0], 2 * steps)
    twice = waves(moving_phase(images, phases)[0], 2 * steps)
    assert twice < at_most * min(once, plain)
    still = np.stack([0.4 + 0.3 * np.cos(start + p) for p in phases])
    np.testing.assert_allclose(wrap(moving_phase(still, phases)[0] - start), 0, atol=1e-9)


def test_waves_that_gamma_leaves_are_evened_out():
    truth = wrap(np.linspace(0, 40 * np.pi, 6000)[None])
    phases = 2 * np.pi / 3 * np.array([-1.0, 0.0, 1.0])
    light = np.array([1.0, 1.03, 0.96])[:, None, None]
    images = light * np.stack([(0.5 + 0.45 * np.cos(truth + p)) ** 1.3 for p in phases])
    phase, _ = wrapped_phase(images, phases)
    even = evened_phase(phase, np.ones_like(truth, bool), 400.0)
    inner = np.s_[:, 900:-900]
    assert np.abs(wrap(even - truth))[inner].mean() < 0.25 * np.abs(wrap(phase - truth))[inner].mean()


def test_unwrapping_gives_back_a_surface_up_to_whole_turns_round_a_hole():
    x, y = np.meshgrid(np.arange(70), np.arange(50))
    truth = 0.35 * x + 0.002 * (y - 25.0) ** 2
    mask = (x - 30) ** 2 + (y - 20) ** 2 > 60
    mask[:, 60] = False
    found = unwrap(wrap(truth), mask)
    assert np.isnan(found[~mask]).all()
    for piece in (np.s_[:, :60], np.s_[:, 61:]):
        off = (found - truth)[piece][mask[piece]] / (2 * np.pi)
        np.testing.assert_allclose(off, np.round(off[0]), atol=1e-9)


def test_a_fault_is_kept_off_the_path():
    truth = np.tile(0.3 * np.arange(60.0), (40, 1))
    truth[15:25, 30] += 2.0
    found = unwrap(wrap(truth), np.ones_like(truth, bool))
    off = (found - truth) / (2 * np.pi)
    off -= off[0, 0]
    assert (np.abs(off[:, :29]) < 1e-6).all()
    assert (np.abs(off[:, 32:]) < 1e-6).all()
    assert bending(wrap(truth), np.ones_like(truth, bool))[20, 30] > 1


def test_missing_bits_and_mixed_periods_are_refused():
    patterns = gray_set(256, 64)
    fewer = replace(patterns, patterns=patterns.patterns[2:])
    with pytest.raises(BadInput, match="axis x needs 8 gray bits"):
        decode_gray(capture(fewer), fewer)
    shifts = phase_set(256, 64)
    with pytest.raises(BadInput, match="1 round"):
        phase_set(256, 64, rounds=0)
    odd = replace(shifts, patterns=(replace(shifts.patterns[0], periods=3.0), *shifts.patterns[1:]))
    with pytest.raises(BadInput, match="one period"):
        decode_phase(capture(odd), odd)
