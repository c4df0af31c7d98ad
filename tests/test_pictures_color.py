"""sRGB and linear light."""

import numpy as np

from mien.pictures.color import to_linear, to_srgb


def test_srgb_round_trip_and_known_values():
    levels = np.linspace(0, 1, 256)
    np.testing.assert_allclose(to_srgb(to_linear(levels)), levels, atol=1e-12)
    np.testing.assert_allclose(to_linear(np.array([0.5])), [0.21404114], atol=1e-8)
