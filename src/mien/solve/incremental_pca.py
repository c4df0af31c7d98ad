"""Principal components that follow a stream of samples, by expectation maximisation in the space of the samples."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32
from scipy.linalg import cholesky, solve_triangular

RIDGE = 1e-10
"""Keeps the small systems solvable where samples depend on one another; relative to their trace."""


@dataclass(frozen=True)
class IncrementalPcaConfig:
    """Sizes; the defaults are the paper's."""

    components: int = 7
    """Corrective shapes, K."""
    buffer: int = 200
    """Samples that are remembered, S; the oldest leaves first."""
    warm_up: int = 200
    """Samples before the first update; until then the first K samples, made orthonormal, are the basis."""
    steps: int = 2
    """EM steps an update."""


class IncrementalPca:
    """The K leading directions of the last S samples (Li et al. 2013, sec. 5; Roweis 1998).

    The basis M (n, K) is kept as M = S A with the samples S (n, s) and coefficients A (s, K). Both EM steps then need
    only the Gram matrix S'S, which changes by one row when a sample enters; the long samples are touched twice an
    update, once for that row and once for M itself. Samples are not centred: they are offsets already.

    Samples and basis are float32 (relative accuracy about 1e-6), the Gram matrix and the steps float64.
    """

    def __init__(self, length: int, config: IncrementalPcaConfig = IncrementalPcaConfig()):
        if not 0 < config.components <= min(config.warm_up, config.buffer) or config.warm_up > config.buffer:
            raise ValueError(
                "config: expected 0 < components <= warm_up <= buffer, "
                f"got {config.components}, {config.warm_up}, {config.buffer}"
            )
        self.config = config
        self.count = 0
        """Samples taken so far."""
        self._samples = np.zeros((config.buffer, length), dtype=np.float32)
        self._gram = np.zeros((config.buffer, config.buffer))
        self._mix = np.zeros((config.buffer, config.components))
        self._basis = np.zeros((length, 0), dtype=np.float32)

    @property
    def basis(self) -> Float32[np.ndarray, "n k"]:
        """Orthonormal columns; none before K samples have come."""
        return self._basis

    @property
    def gram(self) -> Float[np.ndarray, "s s"]:
        """Inner products of the samples in the buffer."""
        return self._gram[: self._held, : self._held]

    @property
    def _held(self) -> int:
        return min(self.count, self.config.buffer)

    def add(self, sample: Float[np.ndarray, " n"]) -> bool:
        """Take a sample and, once there are enough, update the basis; whether the basis changed.

        Raises:
            ValueError: wrong length, or not finite.
        """
        if sample.shape != self._samples.shape[1:] or not np.isfinite(sample).all():
            raise ValueError(f"sample: expected {self._samples.shape[1]} finite numbers, got shape {sample.shape}")
        projections = self._enter(sample.astype(np.float32))
        if self.count == self.config.components:
            self._mix[: self.count] = np.eye(self.count)
        elif self.count >= self.config.warm_up:
            for coefficients in self._expectations(projections):
                self._mix[: self._held] = _maximise(coefficients)
        else:
            return False
        self._orthonormalise()
        return True

    def _enter(self, sample):
        """Store the sample in the place of the oldest; M'S for the M before it and the S after it."""
        place = self.count % self.config.buffer
        products = (self._samples[: self._held] @ sample).astype(np.float64)
        mix = self._mix[: self._held]
        projections = mix.T @ self._gram[: self._held, : max(self._held, place + 1)]
        projections[:, place] = mix.T @ products
        self._samples[place] = sample
        self.count += 1
        self._gram[place, : len(products)] = self._gram[: len(products), place] = products
        self._gram[place, place] = float(np.dot(sample, sample))
        return projections

    def _expectations(self, projections):
        """The E-steps: coefficients Y (K, s) of every sample; the first from an orthonormal M, so Y = M'S."""
        yield projections
        for _ in range(self.config.steps - 1):
            mix = self._mix[: self._held]
            cross = mix.T @ self.gram
            yield np.linalg.solve(_ridged(cross @ mix), cross)

    def _orthonormalise(self):
        """QR of M by Cholesky: first in the space of samples, then once on M itself for float32's sake."""
        mix = self._mix[: self._held]
        triangle = cholesky(_ridged(mix.T @ self.gram @ mix), check_finite=False)
        mix = solve_triangular(triangle, mix.T, trans=1, check_finite=False).T
        basis = self._samples[: self._held].T @ mix.astype(np.float32)
        again = cholesky(_ridged((basis.T @ basis).astype(np.float64)), check_finite=False)
        self._mix[: self._held] = solve_triangular(again, mix.T, trans=1, check_finite=False).T
        undo = solve_triangular(again, np.eye(len(again)), check_finite=False).astype(np.float32)
        self._basis = basis @ undo


def _maximise(coefficients):
    """The M-step, A = Y'(YY')^-1 for M = SA."""
    return np.linalg.solve(_ridged(coefficients @ coefficients.T), coefficients).T


def _ridged(matrix):
    return matrix + RIDGE * max(np.trace(matrix) / len(matrix), 1e-300) * np.eye(len(matrix))
