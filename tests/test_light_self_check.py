from dataclasses import replace

import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.decode_phase import decode_phase
from mien.light.decode_sinusoids import DecodeConfig
from mien.light.patterns import gray_set, paper_set, phase_set, profile
from mien.light.self_check import check_gradients, check_signal

WIDTH, HEIGHT = 256, 256
BLUR = np.array([0.06, 0.24, 0.4, 0.24, 0.06])
"""Of the lens, projector pixels."""
KINDS = {"paper": paper_set(WIDTH, HEIGHT), "phase": phase_set(WIDTH, HEIGHT, 4, 32.0), "gray": gray_set(WIDTH, HEIGHT)}


def pictures(patterns, room=0.02):
    """A matt wall of even reflectance: columns and rows of the projector run a little askew over the picture."""
    y, x = np.mgrid[:150, :180]
    column, row = 30 + 1.1 * x + 0.06 * y, 40 + 0.05 * x + 1.1 * y
    rng = np.random.default_rng(1)
    images = []
    for pattern in patterns.patterns:
        light = np.full(x.shape, 0.6)
        if pattern.kind not in ("constant", "gradient", "tracking"):
            values = np.convolve(np.pad(profile(pattern, WIDTH), 2, mode="edge"), BLUR, mode="valid")
            light = np.interp(row if pattern.axis == "y" else column, np.arange(WIDTH), values)
        images.append(np.clip(0.7 * (light + room) + rng.normal(0, 0.003, x.shape), 0, 1))
    return np.stack(images)


@pytest.fixture(scope="module", params=list(KINDS))
def shown(request):
    return KINDS[request.param], pictures(KINDS[request.param])


def tell(images, patterns, gamma=1.0):
    check_signal(images, patterns, "left", gamma, DecodeConfig())


def test_linear_pictures_in_order_pass_noise_and_room_light_too(shown):
    patterns, images = shown
    tell(images, patterns)
    tell(np.clip(images + np.random.default_rng(0).normal(0, 0.02, images.shape), 0, 1), patterns)
    tell(pictures(patterns, room=0.25), patterns)


def test_a_camera_of_8_bits_and_gamma_is_told_with_its_exponent(shown):
    patterns, images = shown
    with pytest.raises(BadInput, match=r"left: the camera looks gamma-encoded.* gamma 2\.2, not 1\.0"):
        tell(np.round(255 * images ** (1 / 2.2)) / 255, patterns)
    with pytest.raises(BadInput, match=r"gamma 1\.0, not 2\.2"):
        tell(images**2.2, patterns, gamma=2.2)


def test_a_wrong_order_is_told(shown):
    patterns, images = shown
    for wrong in (np.roll(images, 1, axis=0), images[::-1]):
        with pytest.raises(BadInput, match=r"order|do not follow"):
            tell(wrong, patterns)


@pytest.mark.parametrize(("one", "other"), [(0, 1), (3, 4), (4, 5), (5, 6), (6, 7)])
def test_two_slots_that_changed_places_are_named(one, other):
    images = pictures(KINDS["paper"])
    images[[one, other]] = images[[other, one]]
    with pytest.raises(BadInput, match=f"slot {one} .* is shown in slot {other}; 2 of 12"):
        tell(images, KINDS["paper"])


def test_bits_that_come_fine_to_coarse_are_told():
    patterns, images = KINDS["gray"], pictures(KINDS["gray"])
    backwards = np.concatenate(
        [images[:16].reshape(8, 2, *images.shape[1:])[::-1].reshape(images[:16].shape), images[16:]]
    )
    with pytest.raises(BadInput, match="changes less often than the coarser bit"):
        tell(backwards, patterns)


def test_steps_of_a_phase_shift_in_another_order_are_told():
    patterns, images = KINDS["phase"], pictures(KINDS["phase"])
    decode_phase(images, patterns)
    with pytest.raises(BadInput, match="wrong order of the steps"):
        decode_phase(images[[1, 0, *range(2, len(images))]], patterns)


def test_lamps_in_another_order_are_told_by_the_surface():
    patterns = KINDS["paper"]
    _, normals = light_scene.ball_depth(light_scene.rig().cameras[0])
    turned = np.nan_to_num(normals) @ np.diag([1.0, -1.0, -1.0])
    images = np.full((len(patterns), *normals.shape[:2]), 0.5)
    for slot in patterns.of("gradient"):
        images[slot] = 0.5 * (1 + 2 / 3 * turned[..., "xyz".index(patterns.patterns[slot].axis)]) / 2
    R = np.diag([1.0, -1.0, -1.0])
    check_gradients(images, patterns, R, normals)
    for one, other in ((8, 9), (9, 10), (7, 10)):
        wrong = images.copy()
        wrong[[one, other]] = images[[other, one]]
        with pytest.raises(BadInput, match="another order"):
            check_gradients(wrong, patterns, R, normals)
    swapped = replace(patterns, patterns=patterns.patterns[::-1])
    check_gradients(images[::-1], swapped, R, normals)
