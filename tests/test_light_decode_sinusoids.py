from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.light.decode_sinusoids import DecodeConfig, decode_sinusoids, structured_moment
from mien.light.patterns import paper_set, sinusoid

PATTERNS = paper_set(512, 384)
H, W = 40, 160


def columns(slot=0.0, drift=0.0):
    x, y = np.meshgrid(np.arange(W), np.arange(H))
    return 60 + 2.3 * x + 4 * np.sin(y / 9) + drift * (slot - structured_moment(PATTERNS))


def capture(drift=0.0, noise=0.004, fading=0.0, seed=0):
    rng = np.random.default_rng(seed)
    images = np.zeros((12, H, W))
    for slot in PATTERNS.of("sinusoid"):
        images[slot] = sinusoid(PATTERNS.patterns[slot], columns(slot, drift), 512)
        if fading and PATTERNS.patterns[slot].periods > 4:
            images[slot] = 0.5 + (images[slot] - 0.5) * np.linspace(1, 1 - fading, W)
    images[PATTERNS.one("full")] = 1.0
    return np.clip(0.7 * images + noise * rng.normal(size=images.shape), 0, None)


def error(decoded):
    return np.abs(decoded.pixel - columns())[decoded.known]


def test_columns_are_found_to_a_fraction_of_a_pixel_over_the_whole_picture():
    decoded = decode_sinusoids(capture(), PATTERNS)
    assert decoded.known[2:-2, 2:-2].mean() > 0.99
    assert np.median(error(decoded)) < 0.05
    assert (error(decoded) > 1).mean() < 0.01
    assert 0.3 < np.median(error(decoded)) / np.nanmedian(decoded.sigma) < 1.5


def test_contrast_that_fades_over_the_picture_is_found_and_not_taken_for_phase():
    faded = capture(fading=0.5)
    decoded = decode_sinusoids(faded, PATTERNS)
    one_contrast = decode_sinusoids(faded, PATTERNS, DecodeConfig(rounds=0))
    assert 0.65 < decoded.contrast[-1] < 0.85
    assert error(decoded).mean() < 0.6 * error(one_contrast).mean()


def test_a_face_that_moves_between_patterns_is_found_at_one_moment():
    moving = capture(drift=0.25)
    still = replace(DecodeConfig(), motion=False)
    assert (
        error(decode_sinusoids(moving, PATTERNS)).mean() < 0.4 * error(decode_sinusoids(moving, PATTERNS, still)).mean()
    )


def test_shadow_and_glare_are_left_out():
    images = capture()
    images[:, 10:20, 10:20] *= 0.02
    images[:, 25:30, 40:60] = 1.0
    decoded = decode_sinusoids(images, PATTERNS)
    assert not decoded.known[12:18, 12:18].any()
    assert not decoded.known[25:30, 40:60].any()


def test_a_black_frame_takes_the_rooms_light_off():
    patterns = replace(PATTERNS, patterns=(*PATTERNS.patterns, replace(PATTERNS.patterns[6], kind="black")))
    room = np.concatenate([capture(), np.zeros((1, H, W))]) + 0.15
    assert error(decode_sinusoids(room, patterns)).mean() < 0.5 * error(decode_sinusoids(room[:12], PATTERNS)).mean()


def test_slots_out_of_order_show_in_the_misfit():
    images = capture()
    images[[3, 4]] = images[[4, 3]]
    assert decode_sinusoids(images, PATTERNS).misfit > 20 * decode_sinusoids(capture(), PATTERNS).misfit


def test_dark_pictures_and_too_few_patterns_are_refused():
    with pytest.raises(BadInput, match="dark"):
        decode_sinusoids(np.zeros((12, H, W)), PATTERNS)
    with pytest.raises(BadInput, match="saturated"):
        decode_sinusoids(np.ones((12, H, W)), PATTERNS)
    few = replace(PATTERNS, patterns=PATTERNS.patterns[4:])
    with pytest.raises(BadInput, match="3 sinusoids"):
        decode_sinusoids(np.ones((8, H, W)), few)


def test_a_dot_that_moves_between_patterns_is_no_pattern_where_its_flow_is_told():
    y, x = np.mgrid[:H, :W].astype(float)
    images = capture(noise=0.0)
    for slot in range(8):
        dots = np.cos((x - 0.3 * slot) * 0.8) * np.cos(y * 0.8)
        images[slot] *= 1 - 0.5 * np.clip(dots, 0, 1)
    flow = np.zeros((H, W, 2))
    flow[..., 0] = -0.3
    plain, told = decode_sinusoids(images, PATTERNS), decode_sinusoids(images, PATTERNS, flow=flow)
    assert error(told).mean() < 0.5 * error(plain).mean()
    assert told.known.mean() >= plain.known.mean()
