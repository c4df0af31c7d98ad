"""Images as their red and black pixels."""

import numpy as np
import pytest

from halves import H, W, random_halves
from mien.flow.checkerboard import fill_frame, framed, pack, unpack


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_pack_is_the_checkerboard_and_unpack_its_inverse(rng):
    image = random_halves(rng, H, W)
    halves = pack(image)
    for y, x in ((0, 0), (0, 1), (3, 4), (8, 11)):
        assert halves[(x + y) % 2, y, x // 2] == image[y, x]
    np.testing.assert_array_equal(unpack(halves), image)


def test_frame_repeats_the_border(rng):
    image = random_halves(rng, H, W)
    wide = np.pad(image, 1, mode="edge")
    u = framed(image)
    for y in range(H):
        for x in range(W):
            k, row, l = (x + y) % 2, y + 1, (y + (x + y)) & 1
            i = x // 2
            around = u[1 - k, row, i + l], u[1 - k, row, i + 1 + l], u[1 - k, row - 1, i + 1], u[1 - k, row + 1, i + 1]
            expected = wide[row, x], wide[row, x + 2], wide[row - 1, x + 1], wide[row + 1, x + 1]
            assert around == expected


def test_fill_frame_keeps_the_inside(rng):
    u = framed(random_halves(rng, H, W))
    before = u[:, 1:-1, 1:-1].copy()
    u[:, 0], u[:, :, -1] = 7, 7
    u[:, 1:-1, 1:-1] = before
    fill_frame(u)
    np.testing.assert_array_equal(u[:, 1:-1, 1:-1], before)
    assert not (u == 7).any()
