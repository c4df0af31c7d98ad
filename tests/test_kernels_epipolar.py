import numpy as np

from mien._kernels import epipolar, epipolar_twin


def matched(module, left, right, first=-5.0, last=40.0):
    disparity, crossings = np.empty_like(left), np.zeros(left.shape, np.int64)
    module.match_rows(left, right, first, last, disparity, crossings)
    return disparity, crossings


def test_a_shifted_ramp_gives_its_shift_and_twins_agree():
    x = np.arange(90.0)
    left, right = np.tile(3 * x, (4, 1)), np.tile(3 * (x + 7.25), (4, 1))
    left[2, 30:34] = np.nan
    right[3, ::17] = np.nan
    made, twin = matched(epipolar, left, right), matched(epipolar_twin, left, right)
    np.testing.assert_allclose(made[0], twin[0])
    np.testing.assert_array_equal(made[1], twin[1])
    np.testing.assert_allclose(made[0][0, 20:80], 7.25)
    assert np.isnan(made[0][2, 30:34]).all()


def test_of_several_crossings_the_one_with_the_pixels_own_slope_is_taken():
    left = np.tile(np.arange(60.0), (1, 1))
    right = left.copy() + 4
    right[0, 30:36] = right[0, 30:36][::-1]
    made, twin = matched(epipolar, left, right, 0, 20), matched(epipolar_twin, left, right, 0, 20)
    assert (made[1] > 1).any()
    np.testing.assert_allclose(made[0], twin[0])
