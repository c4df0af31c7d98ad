"""The flow's energy at one level, linearised round a flow, and its relaxation."""

from collections.abc import Iterator
from contextlib import contextmanager

import numba
import numpy as np
from jaxtyping import Float32

from mien._kernels import flow as kernels

from .checkerboard import clear_border, fill_frame, pack, unpack
from .config import FlowConfig
from .constraints import FlowConstraints
from .warp import Level, splat, spline_coefficients

SERIAL = 128 * 128
"""Levels of fewer pixels are worked on by one thread: waking others costs more than they do. All but the reading of the
image always is: sweeps are so short that on a busy machine threads would mostly wait for each other."""
SOURCE_FIELDS = [0, 3, 4, 5, 6, 7]
"""Where `kernels.linearise` leaves value, d/dx, d/dy, d2/dx2, d2/dxdy, d2/dy2 when it subtracts nothing."""

FLAT = 1e-6
"""Slopes of this times the largest value are rounding errors of a constant image."""


class LevelSystem:
    """Buffers and steps of one level. Flows are framed halves u, v (2, h + 2, w / 2 + 2), see `checkerboard`.

    First `linearise` round a flow, then any number of `freeze` (the penalisers' weights) and `sweep`.
    """

    def __init__(self, level: Level, constraints: FlowConstraints | None, config: FlowConfig):
        h, w, c = level.source.shape
        self.config = config
        self._threads = 1 if h * w < SERIAL else numba.get_num_threads()
        self.smoothness = config.smoothness * level.scale[0] ** 0.5
        self._target = spline_coefficients(level.target)
        self._target_weight = level.target_weight
        self._source_weight = pack(level.source_weight)
        self._fields = np.empty((2, c, 8, h, w // 2), np.float32)
        self._inside = np.empty((2, h, w // 2), np.float32)
        self._source, self._scales = self._describe(level)
        self._held, self._constant = _hold(level, constraints, config.constraint)
        self.a = np.empty((2, 3, h, w // 2), np.float32)
        """a11, a12, a22 of every pixel."""
        self.b = np.empty((2, 2, h, w // 2), np.float32)
        self.edges = np.empty((2, 4, h, w // 2), np.float32)
        """Smoothness weights to the left, right, upper and lower neighbour."""
        self._g = np.empty((2, h + 2, w // 2 + 2), np.float32)
        self._rows = np.empty((2, 2, h), np.float32)
        self.u0 = self.v0 = np.empty(0, np.float32)

    def linearise(self, u: np.ndarray, v: np.ndarray) -> None:
        """Linearise the constancies round the flow (u, v)."""
        share, turn = self.config.source_share, self.config.turn_gradients
        self._sample(self._target, self._target_weight, u, v, self._source, self._scales, share, turn)
        self._inside *= self._source_weight
        self.u0, self.v0 = (np.ascontiguousarray(x[:, 1:-1, 1:-1]) for x in (u, v))

    def freeze(self, u: np.ndarray, v: np.ndarray) -> float:
        """Freeze the penalisers' weights at (u, v), fill `a`, `b`, `edges`, and return the linearised energy there."""
        fill_frame(u)
        fill_frame(v)
        epsilon, alpha = np.float32(self.config.smooth_epsilon), np.float32(self.smoothness)
        beta, gamma = np.float32(self.config.brightness), np.float32(self.config.gradient)
        e = np.float32(self.config.data_epsilon)
        with threads(1):
            for k in (0, 1):
                given = self._fields[k], self._inside[k], self._held[k], u[k], v[k], self.u0[k], self.v0[k]
                out = *self.a[k], *self.b[k], self._rows[1, k]
                kernels.data_terms(*given, beta, gamma, e, *out)  # pyright: ignore[reportCallIssue]
                kernels.diffusivity(u[k], v[k], u[1 - k], v[1 - k], k, epsilon, self._g[k], self._rows[0, k])
            for k in (0, 1):
                kernels.edge_weights(self._g[k], self._g[1 - k], k, alpha, self.edges[k])
        clear_border(self.edges)
        smooth, data = self._rows.sum((1, 2), dtype=np.float64)
        return float(data + self.smoothness * smooth + self._held_energy(u, v))

    def sweep(self, u: np.ndarray, v: np.ndarray, sweeps: int, overrelaxation: float) -> None:
        """Relax the frozen system, in place: no sweep raises the energy."""
        omega = np.float32(overrelaxation)
        with threads(1):
            for _ in range(sweeps):
                for k in (0, 1):
                    given = *self.a[k], *self.b[k], self.edges[k], k, omega
                    kernels.relax(u[k], v[k], u[1 - k], v[1 - k], *given)  # pyright: ignore[reportCallIssue]

    def residual(self, u: np.ndarray, v: np.ndarray) -> Float32[np.ndarray, "h w"]:
        """Root mean square difference of the channels at (u, v); NaN where there is no data."""
        self._sample(self._target, self._target_weight, u, v, self._source, np.ones_like(self._scales))
        rms = np.sqrt((self._fields[:, :, 0] ** 2).mean(1))
        return unpack(np.where(self._inside * self._source_weight > 0, rms, np.float32(np.nan)))

    def _sample(self, coefficients, weight, u, v, reference, scales, share: float = 0.0, turn: bool = False) -> None:
        fill_frame(u)
        fill_frame(v)
        with threads(self._threads):
            for k in (0, 1):
                given = u[k], v[k], u[1 - k], v[1 - k], k, reference[k], scales[k], np.float32(share), turn
                out = self._fields[k], self._inside[k]
                kernels.linearise(coefficients, weight, *given, *out)  # pyright: ignore[reportCallIssue]

    def _describe(
        self, level: Level
    ) -> tuple[Float32[np.ndarray, "2 c 6 h half"], Float32[np.ndarray, "2 c 2 h half"]]:
        """The source's value and derivatives, and what residuals of value and gradient are multiplied with."""
        h, w, c = level.source.shape
        nothing = np.zeros((2, c, 6, h, w // 2), np.float32)
        rest = np.zeros((2, h + 2, w // 2 + 2), np.float32)
        coefficients = spline_coefficients(level.source)
        ones = np.ones((2, c, 2, h, w // 2), np.float32)
        self._sample(coefficients, level.source_weight, rest, rest.copy(), nothing, ones)
        source = np.ascontiguousarray(self._fields[:, :, SOURCE_FIELDS])
        first = source[:, :, 1] ** 2 + source[:, :, 2] ** 2
        second = source[:, :, 3] ** 2 + 2 * source[:, :, 4] ** 2 + source[:, :, 5] ** 2
        floor = FLAT**2 * max(float(np.abs(x).max()) for x in (level.source, level.target)) ** 2
        scales = [_inverse_root(s, self._source_weight, self.config.contrast, floor) for s in (first, second)]
        return source, np.stack(scales, 2)

    def _held_energy(self, u: np.ndarray, v: np.ndarray) -> float:
        if self._constant is None:
            return 0.0
        x, z = (f[:, 1:-1, 1:-1].astype(np.float64) for f in (u, v))
        a11, a12, a22, b1, b2 = np.moveaxis(self._held, 1, 0)
        return float((a11 * x * x / 2 + a12 * x * z + a22 * z * z / 2 - b1 * x - b2 * z).sum()) + self._constant


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let the kernels use `count` threads."""
    before = numba.get_num_threads()
    numba.set_num_threads(count)
    try:
        yield
    finally:
        numba.set_num_threads(before)


def _inverse_root(
    squares: Float32[np.ndarray, "2 c h half"], weight: Float32[np.ndarray, "2 h half"], contrast: float, floor: float
) -> Float32[np.ndarray, "2 c h half"]:
    """1 / sqrt(squares + (contrast * their root mean square where there is data)^2).

    0 if that mean square is not above `floor`: the image is flat.
    """
    mean = float((squares.mean(1) * weight).sum(dtype=np.float64) / max(weight.sum(dtype=np.float64), 1e-9))
    if mean <= floor:
        return np.zeros_like(squares)
    return 1 / np.sqrt(squares + np.float32(contrast**2 * mean))


def _hold(
    level: Level, constraints: FlowConstraints | None, strength: float
) -> tuple[Float32[np.ndarray, "2 5 h half"], float | None]:
    """Constraints as a11, a12, a22, b1, b2 of the pixels round them (bilinear shares), and the energy's constant."""
    shape = level.source_weight.shape
    if constraints is None or not len(constraints.source):
        return pack(np.zeros((5, *shape), np.float32)), None
    place, move = constraints.at_scale(level.scale, shape)
    form = strength * constraints.stiffness
    pull = np.einsum("kde,ke->kd", form, move)
    values = np.stack([form[:, 0, 0], form[:, 0, 1], form[:, 1, 1], pull[:, 0], pull[:, 1]], 1)
    planes = splat(place, values, shape).transpose(2, 0, 1)
    return pack(planes.astype(np.float32)), float(np.einsum("kd,kd->", pull, move) / 2)
