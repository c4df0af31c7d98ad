"""Fine-scale registration of scans in one topology (Huang et al. 2011, sec. 6.2, eq. 8-11): wrinkles onto wrinkles.

Every scan is aligned, region by region, with the few scans that are closest to it there: the mean curvature of scan
and neighbours, laid out in one image, is matched by optical flow, and the scan's vertices slide along its surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ...errors import BadInput
from ...image_space.config import FineConfig
from ...image_space.constraints import PairConstraint
from ...image_space.layout import SHOWN, Layout
from ...image_space.local_align import UnwrappedScan, local_align, prewarped
from ...mesh import Mesh
from ...progress import SILENT, Progress
from ...register import Surface
from .pairs_met import PairsMet, pairs_met


@dataclass(frozen=True)
class FineResult:
    """Scans in finer correspondence."""

    vertices: Float[np.ndarray, "scans n 3"]
    """Millimetres."""
    errors: Float[np.ndarray, "scans regions"]
    """Registration error: rms difference of the features from the neighbours', 1/mm."""
    before: Float[np.ndarray, "scans regions"]
    """The same at the start."""
    unreliable: Bool[np.ndarray, "scans regions"]
    neighbours: Int[np.ndarray, "scans regions m"]
    """Closest first."""
    converged: Bool[np.ndarray, "scans regions"]
    """Whether the flow of the last sweep met its tolerance."""
    moved: Float[np.ndarray, " scans"]
    """Mean distance that the vertices of the regions have slid, mm."""
    by_hand: PairsMet | None = None
    """How well constraints are met, if there are any."""


def register_fine(
    shapes: Float[np.ndarray, "scans n 3"],
    faces: Int[np.ndarray, "m 3"],
    regions: dict[str, Float[np.ndarray, " _"]],
    scans: Sequence[Mesh] | None = None,
    weight: Float[np.ndarray, " n"] | None = None,
    config: FineConfig = FineConfig(),
    constraints: Sequence[PairConstraint] = (),
    only: Sequence[int] | None = None,
    start: Float[np.ndarray, "scans n 3"] | None = None,
    progress: Progress = SILENT,
) -> FineResult:
    """Slide the vertices of scans along their surfaces until wrinkles correspond (Huang et al. 2011, eq. 8-11).

    Args:
        shapes: the scans as large-scale registration left them, in one rigid frame, mm.
        regions: soft masks in 0..1 that overlap; what is in none stays where it is.
        scans: the scans themselves in that frame: curvature and colour are then theirs, not those of `shapes`.
        weight: how far each vertex follows, 0..1; None: all the way.
        only: scans to redo, None for all; the others stay as they are in `start`.
        start: the vertices of an earlier result; the scans to redo begin anew.

    Raises:
        BadInput: arrays that do not fit each other, or a scan number that is not there.
    """
    _check(shapes, regions, scans, constraints, only)
    layout = Layout(Mesh(shapes.mean(axis=0), faces), regions, config.pixel_mm, config.alpha)
    chosen = list(range(len(shapes))) if only is None else sorted(set(only))
    unwrapped = _unwrapped(layout, shapes, scans, config, progress)
    if start is not None:
        for i in set(range(len(shapes))) - set(chosen):
            unwrapped[i].resume(start[i])
    near = closest_scans(shapes, regions, config.neighbours)
    before = _errors(layout, unwrapped, near)
    converged = np.ones(near.shape[:2], bool)
    for sweep in range(config.sweeps):
        for count, i in enumerate(chosen):
            converged[i] = local_align(layout, unwrapped, i, near[i], config, constraints)
            progress.update("aligning wrinkles", sweep * len(chosen) + count + 1, config.sweeps * len(chosen))
    vertices = shapes.copy() if start is None else start.copy()
    follow = 1.0 if weight is None else weight[:, None]
    for i in chosen:
        vertices[i] = shapes[i] + follow * (unwrapped[i].vertices() - shapes[i])
    moved = np.linalg.norm(vertices - shapes, axis=2)[:, layout.vertices].mean(axis=1)
    errors = _errors(layout, unwrapped, near)
    met = pairs_met(constraints, faces, shapes if start is None else start, vertices) if constraints else None
    return FineResult(vertices, errors, before, errors > config.unreliable, near, converged, moved, met)


def _unwrapped(
    layout: Layout, shapes: np.ndarray, scans: Sequence[Mesh] | None, config: FineConfig, progress: Progress
) -> list[UnwrappedScan]:
    """Every scan laid out."""
    found = []
    for i, shape in enumerate(shapes):
        found.append(UnwrappedScan(layout, shape, Surface(scans[i]) if scans else None, config))
        progress.update("looking at the skin", i + 1, len(shapes))
    return found


def closest_scans(
    shapes: Float[np.ndarray, "scans n 3"], regions: dict[str, Float[np.ndarray, " n"]], count: int
) -> Int[np.ndarray, "scans regions m"]:
    """For every scan and region the `count` scans closest to it there, closest first; fewer if there are no more.

    The distance is rms over the region's vertices after the best rigid motion between the two.
    """
    scans = len(shapes)
    out = np.empty((scans, len(regions), min(count, scans - 1)), np.int64)
    for r, mask in enumerate(regions.values()):
        used = mask > SHOWN
        w = mask[used] / mask[used].sum()
        x = shapes[:, used] - np.einsum("n,snd->sd", w, shapes[:, used])[:, None]
        size = np.einsum("n,snd,snd->s", w, x, x)
        H = np.einsum("n,snd,tne->stde", w, x, x)
        sigma = np.linalg.svd(H, compute_uv=False)
        sigma[..., 2] *= np.sign(np.linalg.det(H))
        squared = size[:, None] + size[None, :] - 2 * sigma.sum(axis=2)
        np.fill_diagonal(squared, np.inf)
        out[:, r] = np.argsort(squared, axis=1, kind="stable")[:, : out.shape[2]]
    return out


def _errors(
    layout: Layout, unwrapped: list[UnwrappedScan], near: Int[np.ndarray, "scans regions m"]
) -> Float[np.ndarray, "scans regions"]:
    """Rms difference of curvature from the neighbours', over each region, 1/mm; 0 without neighbours."""
    out = np.zeros(near.shape[:2])
    if not near.shape[2]:
        return out
    for i, scan in enumerate(unwrapped):
        who = np.unique(near[i])
        theirs = prewarped(layout, scan, [unwrapped[k] for k in who], lambda s: [s.curvature])[0]
        squared = (theirs - scan.curvature[..., None]) ** 2
        known = np.isfinite(squared)
        squared[~known] = 0
        for r, members in enumerate(near[i]):
            at = np.searchsorted(who, members)
            weight = layout.masks[..., r, None] * known[..., at]
            out[i, r] = np.sqrt((squared[..., at] * weight).sum() / max(weight.sum(), 1e-12))
    return out


def _check(shapes, regions, scans, constraints, only) -> None:
    n = shapes.shape[1]
    if not regions:
        raise BadInput("fine registration: no regions are given; at least one is needed")
    wrong = [name for name, mask in regions.items() if mask.shape != (n,)]
    if wrong:
        raise BadInput(f"fine registration: region {wrong[0]} must have one value for each of the {n} vertices")
    if scans is not None and len(scans) != len(shapes):
        raise BadInput(f"fine registration: {len(scans)} surfaces for {len(shapes)} scans; give one each")
    if not all(0 <= i < len(shapes) for c in constraints for i in c.scans):
        raise BadInput(f"fine registration: constraints must name scans from 0 to {len(shapes) - 1}")
    if only is not None and not all(0 <= i < len(shapes) for i in only):
        raise BadInput(f"fine registration: scans to redo must be numbers from 0 to {len(shapes) - 1}")
