"""Principal components that follow a stream of samples, by expectation maximisation in the space of the samples."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from .._kernels.mix import combine, products

RIDGE = 1e-10
"""Keeps the small systems solvable where samples depend on one another; relative to their trace."""

DEPENDENT = 1e-6
"""Directions whose variance is below this part of the largest cannot be told from the rounding of float32."""


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
        self._rows = np.zeros((0, length), dtype=np.float32)
        self._projections: Float[np.ndarray, "k s"] | None = None

    @property
    def pending(self) -> bool:
        """Whether a sample has entered that the basis does not know of yet."""
        return self._projections is not None

    @property
    def basis(self) -> Float32[np.ndarray, "n k"]:
        """Orthonormal columns; none before K samples have come, and columns of 0 while these hold fewer directions."""
        return self._rows.T

    @property
    def gram(self) -> Float[np.ndarray, "s s"]:
        """Inner products of the samples in the buffer."""
        return _packed(self._gram[: self._held, : self._held])

    @property
    def _held(self) -> int:
        return min(self.count, self.config.buffer)

    def add(self, sample: Float[np.ndarray, " n"]) -> bool:
        """Take a sample and, once there are enough, update the basis; whether the basis changed.

        Raises:
            ValueError: wrong length, or not finite.
        """
        self.enter(sample)
        return self.update()

    def enter(self, sample: Float[np.ndarray, " n"]) -> None:
        """Take a sample and leave the basis as it is: half the work of `add`, `update` is the other.

        Raises:
            ValueError: wrong length, or not finite.
        """
        if sample.shape != self._samples.shape[1:] or not np.isfinite(sample).all():
            raise ValueError(f"sample: expected {self._samples.shape[1]} finite numbers, got shape {sample.shape}")
        self._projections = self._enter(sample.astype(np.float32))

    def update(self) -> bool:
        """Let the basis follow the last sample, once there are enough; whether it changed."""
        projections, self._projections = self._projections, None
        if projections is None:
            return False
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
        held, mix = self._held, self._mix[: self._held]
        inner = products(self._samples[:held], sample)
        projections = combine(_packed(self._gram[:held, : max(held, place + 1)]), mix)
        projections[:, place] = inner @ mix
        self._samples[place] = sample
        self.count += 1
        self._gram[place, :held] = self._gram[:held, place] = inner
        self._gram[place, place] = products(sample[None], sample)[0]
        return projections

    def _expectations(self, projections):
        """The E-steps: coefficients Y (K, s) of every sample; the first from an orthonormal M, so Y = M'S."""
        yield projections
        for _ in range(self.config.steps - 1):
            mix = self._mix[: self._held]
            cross = combine(self.gram, mix)
            yield np.linalg.solve(_ridged(cross @ mix), cross)

    def _orthonormalise(self):
        """QR of M by Cholesky: first in the space of samples, then once on M itself for float32's sake."""
        mix = self._mix[: self._held]
        square = combine(self.gram, mix) @ mix
        spread = np.linalg.eigvalsh(square)
        if spread[0] <= DEPENDENT * spread[-1]:
            self._reseed()
            return
        mix = mix @ _whitening(square)
        rows = combine(self._samples[: self._held], _single(mix))
        again = _whitening(np.array([products(rows, row) for row in rows]))
        self._mix[: self._held] = mix @ again
        self._rows = combine(rows, _single(again))

    def _reseed(self):
        """True PCA of the buffer, in place of EM, while it holds fewer than K directions; the rest are columns of 0."""
        values, vectors = np.linalg.eigh(self.gram)
        values, vectors = values[: -self.config.components - 1 : -1], vectors[:, : -self.config.components - 1 : -1]
        there = values > DEPENDENT * max(values[0], 1e-300)
        self._mix[: self._held] = np.where(there, vectors / np.sqrt(np.where(there, values, 1.0)), 0.0)
        self._rows = combine(self._samples[: self._held], _single(self._mix[: self._held]))


def _maximise(coefficients):
    """The M-step, A = Y'(YY')^-1 for M = SA."""
    return np.linalg.solve(_ridged(coefficients @ coefficients.T), coefficients).T


def _whitening(square):
    """R^-1 of M = QR, from M'M = R'R. By inverse: a triangular solve this small would wake a BLAS's threads."""
    return np.linalg.inv(np.linalg.cholesky(square).T)


def _single(matrix):
    return np.ascontiguousarray(matrix, dtype=np.float32)


def _packed(matrix):
    """Rows without gaps, whether or not the buffer is full: a kernel is compiled once for them, not again live."""
    return np.ascontiguousarray(matrix)


def _ridged(matrix):
    return matrix + RIDGE * max(np.trace(matrix) / len(matrix), 1e-300) * np.eye(len(matrix))
