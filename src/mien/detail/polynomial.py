"""Polynomials of two parameters at every texel: fitted by least squares, evaluated (Ma et al. 2008, eq. 1, 4.2)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

from .._kernels import polymap
from ..errors import BadInput
from .domain import SIZE

EXPONENTS: dict[int, Int[np.ndarray, "m 2"]] = {
    1: np.array([[1, 0], [0, 1], [0, 0]]),
    2: np.array([[2, 0], [0, 2], [1, 1], [1, 0], [0, 1], [0, 0]]),
    3: np.array([[3, 0], [0, 3], [2, 1], [1, 2], [2, 0], [0, 2], [1, 1], [1, 0], [0, 1], [0, 0]]),
}
"""Powers of d1 and d2 of every term, by order; of the second, in the order of eq. 1."""
BIQUADRATIC = 2
"""The order that has a compiled loop of its own."""
CHUNK = 1 << 16
"""Texels whose systems are solved at a time."""
OUT_OF_REACH = 6e4
"""A value that no map comes to, and that 16 bits still hold."""


def exponents(order: int, whole_deformation: bool = False) -> Int[np.ndarray, "m q"]:
    """Powers of d1 and d2, or of them and the five entries of the deformation, of every term; the constant is last."""
    of_two = EXPONENTS[order]
    if not whole_deformation:
        return of_two
    above = of_two[of_two.sum(axis=1) > 1]
    linear = np.zeros((SIZE + 1, SIZE), int)
    linear[:SIZE] = np.eye(SIZE, dtype=int)
    return np.block([[above, np.zeros((len(above), SIZE), int)], [np.zeros((SIZE + 1, 2), int), linear]])


@dataclass(frozen=True)
class PolynomialConfig:
    """The form of a map and what holds its coefficients back."""

    order: int = 2
    """1: linear, 3 terms; 2: biquadratic, 6; 3: bicubic, 10."""
    regularisation: float = 0.05
    """sigma of the rows on all coefficients but the constant, unit-free: a term of degree g weighs sigma rms(d)^g."""
    whole_deformation: bool = False
    """Linear in all five entries of the deformation in place of d1 and d2 alone (past the paper): three terms more."""

    def __post_init__(self):
        if self.order not in EXPONENTS:
            raise BadInput(f"displacement map: order is {self.order}; give 1, 2 or 3")
        if self.regularisation < 0:
            raise BadInput("displacement map: regularisation is 0 or more")


@dataclass(frozen=True)
class PolynomialMap:
    """Coefficients at every texel of a `Texels`."""

    coefficients: Float32[np.ndarray, "p m c"]
    """Millimetres by mm^-degree; c channels."""
    order: int
    """Of the terms in d1 and d2, as in `PolynomialConfig`."""
    seen: Bool[np.ndarray, " p"]
    """False at texels that no training frame showed: their coefficients are 0, or filled in from round them."""
    limits: Float32[np.ndarray, "p 2 c"] | None = None
    """Least and greatest value at each texel in training, between which the map stays; None: it may go on."""
    whole_deformation: bool = False

    @property
    def biquadratic(self) -> bool:
        """Eq. 1 as the paper has it."""
        return self.order == BIQUADRATIC and not self.whole_deformation

    def evaluate(self, parameters: Float32[np.ndarray, "p q"]) -> Float32[np.ndarray, "p c"]:
        """The map's values (eq. 1) under d1 and d2, and the whole deformation if so made, at every texel."""
        out = np.empty((len(parameters), self.coefficients.shape[2]), np.float32)
        polymap.evaluate(self.coefficients, parameters, exponents(self.order, self.whole_deformation), out)
        return out if self.limits is None else np.clip(out, self.limits[:, 0], self.limits[:, 1])

    def with_limits(self) -> Float32[np.ndarray, "p m_2 c"]:
        """The coefficients and after them the limits, out of reach where there are none."""
        limits = self.limits
        if limits is None:
            ends = np.array([-OUT_OF_REACH, OUT_OF_REACH], np.float32)[:, None]
            limits = np.broadcast_to(ends, (len(self.coefficients), 2, self.coefficients.shape[2]))
        return np.concatenate([self.coefficients, limits], 1)


class PolynomialFit:
    """Normal equations of every texel at once, filled frame by frame: memory does not grow with the frames."""

    def __init__(self, points: int, channels: int, config: PolynomialConfig = PolynomialConfig()):
        self.config = config
        self.exponents = exponents(config.order, config.whole_deformation)
        m = len(self.exponents)
        self._gram = np.zeros((points, m * (m + 1) // 2))
        self._linear = np.zeros((points, m, channels))
        self._count = np.zeros(points)
        self._energy = np.zeros(points)
        self._square = 0.0
        self._frames = 0

    def add(
        self,
        parameters: Float[np.ndarray, "p q"],
        values: Float[np.ndarray, "p c"],
        weights: Float[np.ndarray, " p"] | None = None,
    ) -> None:
        """One frame: parameters and what was measured at every texel; NaN, or a weight of 0, where nothing was."""
        weight = np.ones(1) if weights is None else weights
        d = np.ascontiguousarray(parameters, np.float64)
        polymap.accumulate(self._gram, self._linear, self._count, self._energy, d, values, weight, self.exponents)
        self._square += float((parameters**2).mean())
        self._frames += 1

    def solve(self) -> PolynomialMap:
        """The coefficients: one small positive definite system a texel.

        Raises:
            BadInput: fewer than two frames.
        """
        if self._frames < 2:
            raise BadInput(f"displacement map: {self._frames} frames of training; at least 2 are needed")
        degree = self.exponents.sum(axis=1)
        s = np.sqrt(max(self._square / self._frames, 1e-12))
        held = np.where(degree > 0, (self.config.regularisation * s**degree) ** 2, 0.0)
        m = len(self.exponents)
        rows, columns = np.triu_indices(m)
        out = np.zeros(self._linear.shape, np.float32)
        seen = self._count > 0
        for first in range(0, len(out), CHUNK):
            part = first + np.flatnonzero(seen[first : first + CHUNK])
            gram = np.zeros((len(part), m, m))
            gram[:, rows, columns] = gram[:, columns, rows] = self._gram[part]
            gram += self._count[part, None, None] * np.diag(held) + 1e-12 * np.eye(m)
            out[part] = np.linalg.solve(gram, self._linear[part])
        return PolynomialMap(out, self.config.order, seen, whole_deformation=self.config.whole_deformation)

    @property
    def share(self) -> Float[np.ndarray, " p"]:
        """Of the frames, by weight, that showed each texel."""
        return self._count / max(self._frames, 1)

    def rms(self, polynomial: PolynomialMap) -> Float[np.ndarray, " p"]:
        """Rms length of what the map leaves of the training data at every texel, from the normal equations alone."""
        c = polynomial.coefficients.astype(float)
        rows, columns = np.triu_indices(len(self.exponents))
        twice = np.where(rows == columns, 1.0, 2.0)
        quadratic = np.einsum("pq,q,pqc,pqc->p", self._gram, twice, c[:, rows], c[:, columns])
        left = self._energy - 2 * np.einsum("pmc,pmc->p", c, self._linear) + quadratic
        return np.sqrt(np.maximum(left, 0) / np.where(self._count > 0, self._count, np.nan))
