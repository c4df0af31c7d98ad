import numpy as np

from mien._kernels import sinusoids, sinusoids_twin
from mien.light.patterns import paper_set, profile

PATTERNS = paper_set(256, 64)
WAVES = PATTERNS.patterns[:6]


def pixels(count, seed=0):
    rng = np.random.default_rng(seed)
    table = np.stack([profile(wave, 256) for wave in WAVES])
    ratios = table[:, rng.integers(0, 256, count)].T + 0.01 * rng.normal(size=(count, 6))
    return ratios, rng.uniform(5e3, 2e4, size=(count, 6)), table


def test_search_agrees_with_its_twin():
    ratios, precisions, table = pixels(60)
    steps, windows = np.array([16, 8, 4, 2, 1, 1]), np.array([256, 200, 80, 40, 20, 8])
    tables = np.full((6, 6, 256), np.inf, np.float32)
    for level, step in enumerate(steps):
        tables[level, :, : len(table[0, ::step])] = table[:, ::step]
    told = ratios.astype(np.float32), precisions.astype(np.float32), tables, steps, windows
    made = []
    for module in (sinusoids, sinusoids_twin):
        best = np.zeros(60, np.int64)
        module.search_columns(*told, best)
        made.append(best)
    np.testing.assert_array_equal(*made)


def test_polish_agrees_with_its_twin():
    ratios, precisions, _ = pixels(80, 1)
    rng = np.random.default_rng(2)
    rates = np.array([2 * np.pi * wave.periods / 256 for wave in WAVES])
    shifts = np.array([wave.phase for wave in WAVES]) + rates / 2
    start, drift = rng.uniform(0, 256, 80), 0.1 * rng.normal(size=80)
    contrast, lags = rng.uniform(0.8, 1, size=(80, 6)), np.arange(6.0) - 5.5
    made = []
    for module in (sinusoids, sinusoids_twin):
        columns, sigma, misfit = start.copy(), np.zeros(80), np.zeros(80)
        module.polish_columns(columns, drift, ratios, contrast, precisions, rates, shifts, lags, 3, sigma, misfit)
        made.append((columns, sigma, misfit))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-8)


def test_moments_agree_with_their_twin():
    ratios, precisions, _ = pixels(80, 3)
    rng = np.random.default_rng(4)
    rates = np.array([2 * np.pi * wave.periods / 256 for wave in WAVES])
    told = (rng.uniform(0, 256, 80), 0.1 * rng.normal(size=80), ratios)
    contrast, lags, shifts = rng.uniform(0.8, 1, size=(80, 6)), np.arange(6.0) - 5.5, np.arange(6.0)
    made = []
    for module in (sinusoids, sinusoids_twin):
        contrasts, drifts = np.zeros((80, 6, 2)), np.zeros((80, 2))
        module.contrast_moments(*told, rates, shifts, lags, contrasts)
        module.drift_moments(*told, contrast, precisions, rates, shifts, lags, drifts)
        made.append((contrasts, drifts))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-8)
