"""The compiled kernels of the flow against their numpy twins, and the relaxation against a sparse solve."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from halves import C, H, W, random_halves
from mien._kernels import flow as kernels
from mien._kernels import flow_twin as twins
from mien.flow.checkerboard import clear_border, framed, pack, unpack

HALF = W // 2


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def _both(name, arguments, outputs):
    """Call kernel and twin on copies; return the arrays in `outputs` (positions) of both."""
    results = []
    for module in (kernels, twins):
        copies = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
        getattr(module, name)(*copies)
        results.append([copies[i] for i in outputs])
    return results


def _assert_agree(name, arguments, outputs):
    compiled, plain = _both(name, arguments, outputs)
    for a, b in zip(compiled, plain, strict=True):
        assert np.abs(b).max() > 0
        np.testing.assert_allclose(a, b, rtol=2e-4, atol=2e-5)


@pytest.mark.parametrize(("parity", "turn"), [(0, False), (1, True)])
def test_linearise_agrees(rng, parity, turn):
    flows = [random_halves(rng, H + 2, HALF + 2) for _ in range(4)]
    arguments = [random_halves(rng, C, (H + 3) * (W + 3)), rng.random((H, W), dtype=np.float32), *flows, parity]
    arguments += [random_halves(rng, C, 6, H, HALF), random_halves(rng, C, 2, H, HALF), np.float32(0.3), turn]
    arguments += [np.zeros((C, 8, H, HALF), np.float32), np.zeros((H, HALF), np.float32)]
    _assert_agree("linearise", arguments, (11, 12))


@pytest.mark.parametrize("parity", [0, 1])
def test_diffusivity_agrees(rng, parity):
    flows = [random_halves(rng, H + 2, HALF + 2) for _ in range(4)]
    arguments = [*flows, parity, np.float32(0.1), np.ones((H + 2, HALF + 2), np.float32), np.zeros(H, np.float32)]
    _assert_agree("diffusivity", arguments, (6, 7))


def test_data_terms_agree(rng):
    fields, inside = random_halves(rng, C, 8, H, HALF), rng.random((H, HALF), dtype=np.float32)
    flows = [random_halves(rng, H + 2, HALF + 2) for _ in range(2)] + [random_halves(rng, H, HALF) for _ in range(2)]
    weights = [np.float32(x) for x in (0.4, 1.3, 0.2)]
    out = [np.zeros((H, HALF), np.float32) for _ in range(5)] + [np.zeros(H, np.float32)]
    _assert_agree("data_terms", [fields, inside, random_halves(rng, 5, H, HALF), *flows, *weights, *out], range(10, 16))


@pytest.mark.parametrize("parity", [0, 1])
def test_edge_weights_agree(rng, parity):
    g, og = random_halves(rng, H + 2, HALF + 2), random_halves(rng, H + 2, HALF + 2)
    _assert_agree("edge_weights", [g, og, parity, np.float32(0.7), np.zeros((4, H, HALF), np.float32)], (4,))


@pytest.mark.parametrize("parity", [0, 1])
def test_relax_agrees(rng, parity):
    flows = [random_halves(rng, H + 2, HALF + 2) for _ in range(4)]
    a11, a22 = 1 + rng.random((2, H, HALF), dtype=np.float32)
    rest = [random_halves(rng, H, HALF) for _ in range(2)]
    edges = rng.random((4, H, HALF), dtype=np.float32)
    arguments = [*flows, a11, 0.3 * rest[0], a22, *rest, edges, parity, np.float32(1.5)]
    _assert_agree("relax", arguments, (0, 1))


def test_relaxation_reaches_the_sparse_solution(rng):
    """Sweeps of the checkerboard solve the same 5-point system as a sparse LU on the plain image."""
    g = 0.5 + rng.random((H, W), dtype=np.float32)
    a11, a22 = 0.1 + rng.random((2, H, W), dtype=np.float32)
    a12, b1, b2 = 0.05 * random_halves(rng, H, W), random_halves(rng, H, W), random_halves(rng, H, W)
    u, v, packed_g = framed(np.zeros((H, W), np.float32)), framed(np.zeros((H, W), np.float32)), framed(g)
    edges = np.empty((2, 4, H, HALF), np.float32)
    for k in (0, 1):
        kernels.edge_weights(packed_g[k], packed_g[1 - k], k, np.float32(1), edges[k])
    clear_border(edges)
    halves = [pack(a) for a in (a11, a12, a22, b1, b2)]
    for _ in range(200):
        for k in (0, 1):
            kernels.relax(u[k], v[k], u[1 - k], v[1 - k], *(a[k] for a in halves), edges[k], k, np.float32(1.5))
    L = _weighted_laplacian(g)
    D11, D12, D22 = (sp.diags(a.ravel()) for a in (a11, a12, a22))
    A = sp.bmat([[L + D11, D12], [D12, L + D22]])
    expected = spl.spsolve(A.tocsc(), np.concatenate([b1.ravel(), b2.ravel()])).reshape(2, H, W)
    np.testing.assert_allclose([unpack(u[:, 1:-1, 1:-1]), unpack(v[:, 1:-1, 1:-1])], expected, atol=2e-5)


def _weighted_laplacian(g):
    """Edges between 4-neighbours weigh the mean of the two pixels' g."""
    index = np.arange(H * W).reshape(H, W)
    pairs = [(index[:, :-1], index[:, 1:]), (index[:-1], index[1:])]
    i, j = (np.concatenate([p[n].ravel() for p in pairs]) for n in (0, 1))
    weight = (g.ravel()[i] + g.ravel()[j]) / 2
    W_ = sp.coo_matrix((np.r_[weight, weight], (np.r_[i, j], np.r_[j, i])), shape=(H * W, H * W)).tocsr()
    return sp.diags(np.asarray(W_.sum(1)).ravel()) - W_
