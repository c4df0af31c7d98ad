import numpy as np
import pytest

from mien._kernels import blocks, blocks_twin


@pytest.mark.parametrize("shape", [(9, 7), (1, 5)])
def test_blocks_agree_with_their_twin(shape):
    rng = np.random.default_rng(0)
    rows, columns = rng.integers(0, 4 * shape[0] - 2, 300), rng.integers(0, 4 * shape[1] - 1, 300)
    values = rng.normal(size=(300, 2))
    made = []
    for module in (blocks, blocks_twin):
        sums, out = np.zeros((*shape, 2)), np.zeros((300, 2))
        module.sum_blocks(values, rows, columns, 4, sums)
        module.read_blocks(sums, rows, columns, 4, out)
        made.append((sums, out))
    for one, other in zip(*made, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
