"""Incremental principal components."""

import numpy as np
import pytest

from mien._kernels.mix import combine
from mien.solve import IncrementalPca, IncrementalPcaConfig

SMALL = IncrementalPcaConfig(components=3, buffer=20, warm_up=20)


def stream(seed, count, length=90, rank=3, noise=0.02):
    rng = np.random.default_rng(seed)
    shapes = np.linalg.qr(rng.normal(size=(length, rank)))[0] * np.linspace(3, 1, rank)
    return rng.normal(size=(count, rank)) @ shapes.T + noise * rng.normal(size=(count, length))


def plain(samples, config):
    """EM and QR on the samples themselves, as the paper prints it."""
    basis = np.linalg.qr(samples[: config.components].T)[0]
    for last in range(config.warm_up, len(samples) + 1):
        S = samples[max(0, last - config.buffer) : last].T
        for _ in range(config.steps):
            Y = np.linalg.solve(basis.T @ basis, basis.T @ S)
            basis = np.linalg.solve(Y @ Y.T, Y @ S.T).T
        basis = np.linalg.qr(basis)[0]
    return basis


def projector(basis):
    return basis @ basis.T


def fed(samples, config):
    model = IncrementalPca(samples.shape[1], config)
    for sample in samples:
        model.add(sample)
    return model


@pytest.mark.parametrize("count", [3, 19, 20, 21, 57])
def test_equals_em_and_qr_on_the_samples(count):
    samples = stream(1, count)
    basis = fed(samples, SMALL).basis
    np.testing.assert_allclose(projector(basis), projector(plain(samples, SMALL)), atol=2e-6)


def test_each_column_equals_the_plain_one_up_to_sign():
    samples = stream(2, 33)
    cosines = np.abs(np.sum(fed(samples, SMALL).basis * plain(samples, SMALL), axis=0))
    np.testing.assert_allclose(cosines, 1, atol=1e-5)


def test_converges_to_the_principal_subspace_of_the_buffer():
    samples = stream(3, 20, rank=3, noise=0.3)
    model = fed(np.vstack([samples] * 6), SMALL)
    leading = np.linalg.svd(samples.T)[0][:, :3]
    np.testing.assert_allclose(projector(model.basis), projector(leading), atol=1e-4)


def test_columns_are_orthonormal():
    basis = fed(stream(4, 45), SMALL).basis.astype(np.float64)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-5)


def test_gram_is_that_of_the_last_samples():
    samples = stream(5, 47)
    gram = fed(samples, SMALL).gram
    order = [i % 20 for i in range(27, 47)]
    last = np.empty((20, 90))
    last[order] = samples[27:]
    np.testing.assert_allclose(gram, last @ last.T, rtol=1e-5, atol=1e-5)


def test_follows_a_change_of_subspace_once_the_buffer_has_turned_over():
    model = fed(np.vstack([stream(6, 30), stream(7, 60)]), SMALL)
    new = np.linalg.svd(stream(7, 60).T)[0][:, :3]
    np.testing.assert_allclose(projector(model.basis), projector(new), atol=0.05)


def test_says_when_the_basis_changed():
    model = IncrementalPca(90, SMALL)
    changed = [model.add(sample) for sample in stream(8, 22)]
    assert [i + 1 for i, c in enumerate(changed) if c] == [3, 20, 21, 22]


def test_a_sample_may_enter_first_and_change_the_basis_later():
    whole, halves = IncrementalPca(90, SMALL), IncrementalPca(90, SMALL)
    assert not halves.update()
    for sample in stream(12, 30):
        whole.add(sample)
        before = halves.basis
        halves.enter(sample)
        assert halves.pending
        assert halves.basis.base is before.base
        halves.update()
        assert not halves.pending
    np.testing.assert_array_equal(halves.basis, whole.basis)


def test_an_earlier_start_is_allowed():
    config = IncrementalPcaConfig(components=3, buffer=20, warm_up=5)
    samples = stream(9, 14)
    np.testing.assert_allclose(projector(fed(samples, config).basis), projector(plain(samples, config)), atol=2e-6)


def test_directions_that_the_samples_lack_are_columns_of_zero_until_they_come():
    samples = np.repeat(stream(10, 2), 15, axis=0)
    model = fed(samples, SMALL)
    basis = model.basis.astype(np.float64)
    np.testing.assert_allclose(basis.T @ basis, np.diag([1, 1, 0]), atol=1e-5)
    np.testing.assert_allclose(samples @ projector(basis), samples, atol=1e-4)
    for sample in stream(11, 20):
        model.add(sample)
    np.testing.assert_allclose(np.linalg.norm(model.basis, axis=0), 1, atol=1e-5)


def test_a_full_buffer_does_not_compile_anew():
    """A live loop would stand still for a second when the last place is taken."""
    fed(stream(13, 22), SMALL)
    assert {(str(kind.dtype), kind.layout) for types in combine.signatures for kind in types} <= {
        ("float32", "C"),
        ("float64", "C"),
    }


def test_wrong_samples_and_sizes_are_named():
    model = IncrementalPca(4, SMALL)
    with pytest.raises(ValueError, match="sample: expected 4 finite numbers"):
        model.add(np.zeros(5))
    with pytest.raises(ValueError, match="sample: expected 4 finite numbers"):
        model.add(np.array([0, 0, np.nan, 0]))
    with pytest.raises(ValueError, match="components <= warm_up <= buffer"):
        IncrementalPca(4, IncrementalPcaConfig(components=7, buffer=5))
