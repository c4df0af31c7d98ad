import numpy as np
import pytest

from mien._kernels import multigrid, multigrid_twin

SHAPE = (7, 10)
RNG = np.random.default_rng(0)
F, RIGHT, WEIGHT = RNG.normal(size=(3, *SHAPE))
ACROSS, DOWN = RNG.uniform(0, 2, size=(7, 9)), RNG.uniform(0, 2, size=(6, 10))


@pytest.mark.parametrize("colour", [0, 1])
def test_relax_agrees_with_its_twin_and_solves_its_colour(colour):
    diagonal = np.empty(SHAPE)
    for i in np.ndindex(SHAPE):
        one, out = np.zeros(SHAPE), np.empty(SHAPE)
        one[i] = 1.0
        multigrid_twin.applied(one, WEIGHT**2, ACROSS, DOWN, out)
        diagonal[i] = out[i]
    made = []
    for module in (multigrid, multigrid_twin):
        f, out = F.copy(), np.empty(SHAPE)
        module.relax(f, RIGHT, ACROSS, DOWN, 1 / diagonal, colour)
        module.applied(f, WEIGHT**2, ACROSS, DOWN, out)
        made.append((f, out))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    mine = np.indices(SHAPE).sum(0) % 2 == colour
    np.testing.assert_allclose(made[0][1][mine], RIGHT[mine], atol=1e-12)


def test_fours_agree_with_their_twins():
    made = []
    for module in (multigrid, multigrid_twin):
        coarse, image = np.empty((4, 5)), F.copy()
        module.sum_fours(RIGHT, coarse)
        module.add_to_fours(image, coarse)
        made.append((coarse, image))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    assert made[0][0][3, 4] == pytest.approx(RIGHT[6, 8:].sum())
