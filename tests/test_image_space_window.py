import numpy as np
from scipy import ndimage

from mien.image_space.window import GaussianWindow


def test_a_windows_mean_is_the_gaussian_mean_over_the_mask():
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:120, :150]
    mask = (x - 70) ** 2 + (y - 60) ** 2 < 50**2
    mask &= rng.random(mask.shape) < 0.9
    values = np.where(mask, np.sin(x / 20.0) + 0.2 * rng.normal(size=mask.shape), 0.0)
    for sigma in (12.0, 3.0):
        window = GaussianWindow(mask, sigma)
        sums = window.sums(np.stack([values[mask], np.ones(mask.sum())], 1))
        found = window.at_pixels(sums[..., :1] / np.maximum(sums[..., 1:], 1e-9))[:, 0]
        weight = ndimage.gaussian_filter(mask.astype(float), sigma, truncate=3.0)
        expected = (ndimage.gaussian_filter(values, sigma, truncate=3.0) / np.maximum(weight, 1e-9))[mask]
        assert np.abs(found - expected).mean() < 0.01
