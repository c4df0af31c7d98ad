"""Variational optical flow with warping: Papenberg, Bruhn, Brox, Didas, Weickert 2006.

The flow w = (u, v) takes the source I to the target J: J(x + w) ~ I(x). It minimises (eq. 8 and 11 there, two frames)

    E(w) = sum over pixels of  sum over channels [ beta psi(r) + gamma psi(|g|) ] + alpha phi(|grad w|)  + constraints
    r = (J(x + w) - I(x)) / n_I            brightness constancy
    g = (grad J(x + w) - grad I(x)) / m_I  gradient constancy
    psi(s) = sqrt(s^2 + e^2) - e           robust penaliser; phi the same with its own e

by warping: J(x + w) is linearised round the flow of the last warp, the smoothness never is; within a warp the
penalisers' weights are frozen (lagged nonlinearity) and the linear system relaxed by red-black block SOR. All of it
from coarse to fine. Differences from the paper, and why:

- Every channel, and its brightness and gradient apart, has a penaliser of its own. Channels may come from different
  sources (three neighbouring scans): a wrinkle that one of them lacks must not silence the other two.
- Residuals are divided by the length of the source's gradient (n_I), or of its second derivatives (m_I), each bounded
  below: they become distances in pixels. Strong and faint features then count alike, and no parameter depends on the
  images' units.
- The derivatives in the linearisation are the mean of both images' (`source_share`), which doubles the reach of
  a warp and halves the harm of noise.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Bool, Float

from mien.errors import BadInput

from .checkerboard import framed, unpack
from .config import FlowConfig
from .constraints import FlowConstraints
from .driver import Solved, coarse_to_fine
from .system import LevelSystem
from .warp import Level, pyramid

SMALLEST = 8
"""Pixels a side below which there is nothing to find."""


@dataclass(frozen=True)
class FlowResult:
    """A flow and how it was found. Lists run from the coarsest level to the finest."""

    flow: Float[np.ndarray, "h w 2"]
    """(dx, dy) in pixels: target(x + dx, y + dy) ~ source(x, y)."""
    residual: Float[np.ndarray, "h w"]
    """Root mean square difference of the channels at the flow, in their units; NaN where there is no data."""
    converged: bool
    """Whether the last warp of the finest level moved the flow by less than the tolerance."""
    iterations: list[int]
    """Warps done at each level."""
    energy: list[Float[np.ndarray, "_ inner"]]
    """At each level, the energy before every inner iteration, a row a warp."""


def optical_flow(
    source: Float[np.ndarray, "h w *c"],
    target: Float[np.ndarray, "ht wt *ct"],
    mask: Bool[np.ndarray, "hm wm"] | None = None,
    constraints: FlowConstraints | None = None,
    config: FlowConfig | None = None,
) -> FlowResult:
    """Dense flow from source to target, images of any number of channels (Papenberg et al. 2006).

    Channels should be comparable in range: one scale serves all. Pixels that are NaN in either image, or outside
    `mask` (of the source), count for nothing; the flow there is what smoothness makes of it.

    Raises:
        BadInput: shapes that differ, an image under 8 pixels a side, or no pixel with data.
    """
    config = config or FlowConfig()
    source, target, valid = _checked(source, target, mask)
    box = _box(valid, constraints, config.margin)
    rows, columns = (slice(a, b) for a, b in box)
    known = np.all(np.isfinite(target), axis=2)
    crops = [_even(image[rows, columns]) for image in (source, target, valid[..., None], known[..., None])]
    images, weights = crops[:2], [crop[..., 0].astype(np.float32) for crop in crops[2:]]
    levels = pyramid(images[0], images[1], weights[0], weights[1], config.factor, config.coarsest, config.presmooth)
    local = constraints.moved((columns.start, rows.start)) if constraints else None
    results = coarse_to_fine(levels, partial(solve_level, constraints=local, config=config))
    finest = results[-1]
    inside = (slice(None, rows.stop - rows.start), slice(None, columns.stop - columns.start))
    around = [(a, n - b) for (a, b), n in zip(box, valid.shape, strict=True)]
    return FlowResult(
        flow=np.pad(finest.flow[inside].astype(np.float64), [*around, (0, 0)], mode="edge"),
        residual=np.pad(finest.residual[inside].astype(np.float64), around, constant_values=np.nan),
        converged=finest.converged,
        iterations=[r.iterations for r in results],
        energy=[r.energy for r in results],
    )


def solve_level(
    level: Level, start: Float[np.ndarray, "h w 2"], constraints: FlowConstraints | None, config: FlowConfig
) -> Solved:
    """Warp and relax at one level until the flow moves no more: the inner solver that `coarse_to_fine` takes."""
    if constraints is not None and len(constraints.source):
        start = constraints.start(start, level.scale, config.reach)
    system = LevelSystem(level, constraints, config)
    u, v = framed(start[..., 0]), framed(start[..., 1])
    energies, step = [], np.inf
    while len(energies) < config.warps and step > config.tolerance:
        system.linearise(u, v)
        energies.append([])
        for _ in range(config.inner):
            energies[-1].append(system.freeze(u, v))
            system.sweep(u, v, config.sweeps, config.overrelaxation)
        moved = (u[:, 1:-1, 1:-1] - system.u0) ** 2 + (v[:, 1:-1, 1:-1] - system.v0) ** 2
        step = float(np.sqrt(moved.mean()))
    residual = system.residual(u, v)
    flow = np.stack([unpack(u[:, 1:-1, 1:-1]), unpack(v[:, 1:-1, 1:-1])], -1)
    return Solved(flow, step <= config.tolerance, len(energies), np.array(energies), residual)


def _checked(
    source: np.ndarray, target: np.ndarray, mask: np.ndarray | None
) -> tuple[Float[np.ndarray, "h w c"], Float[np.ndarray, "h w c"], Bool[np.ndarray, "h w"]]:
    """Images with a channel axis and the source's mean taken off (32 bits then hold more), and where there is data."""
    if source.shape != target.shape or source.ndim not in (2, 3):
        shapes = f"source {source.shape} and target {target.shape}"
        raise BadInput(f"optical flow: {shapes} must be two images (h, w) or (h, w, c) of one shape")
    if min(source.shape[:2]) < SMALLEST:
        raise BadInput(f"optical flow: the images are {source.shape[:2]}; give at least {SMALLEST} pixels a side")
    if mask is not None and mask.shape != source.shape[:2]:
        raise BadInput(f"optical flow: mask {mask.shape} must have the images' height and width {source.shape[:2]}")
    source, target = (image.reshape(*image.shape[:2], -1) for image in (source, target))
    valid = np.all(np.isfinite(source), axis=2)
    if mask is not None:
        valid = valid & mask
    if not valid.any() or not np.all(np.isfinite(target), axis=2).any():
        raise BadInput("optical flow: no pixel has data; the mask is empty or an image is all NaN")
    middle = np.mean(source[valid], axis=0)
    return source - middle, target - middle, valid


def _box(valid: np.ndarray, constraints: FlowConstraints | None, margin: int) -> list[tuple[int, int]]:
    """First and last (exclusive) row and column of what is to be solved."""
    places = [np.argwhere(valid)]
    if constraints:
        places.append(np.round(constraints.source[:, ::-1]).astype(int))
    places = np.concatenate(places)
    low = np.clip(places.min(0) - margin, 0, None)
    high = np.minimum(np.maximum(places.max(0) + 1 + margin, low + SMALLEST), valid.shape)
    low = np.maximum(np.minimum(low, high - SMALLEST), 0)
    return [(int(a), int(b)) for a, b in zip(low, high, strict=True)]


def _even(image: np.ndarray) -> np.ndarray:
    """With one more column, of no data, if the width is odd."""
    if image.shape[1] % 2 == 0:
        return image
    nothing = np.zeros((image.shape[0], 1, image.shape[2]), image.dtype)
    return np.concatenate([image, nothing if image.dtype == bool else nothing * np.nan], axis=1)
