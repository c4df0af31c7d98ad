"""One scan aligned with its neighbours (Huang et al. 2011, eq. 9-11): the paper's LocalAlign."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..flow import FlowConstraints, optical_flow
from ..mesh import SurfaceImage, closest_point
from ..register import Surface
from .config import FineConfig
from .constraints import PairConstraint
from .features import averaged, detail, over, raw_images
from .flow_constraints import constraints_in_region, constraints_on, falloff_round
from .layout import SHOWN, Layout, sampled

FAR_MM = 10.0
"""A constraint's point farther than this from the scan is a mistake."""
SMALLEST = 8
"""Pixels a side that a flow needs."""
LEAST = 0.1
"""Evidence below which a region is left as it is."""


class UnwrappedScan:
    """One scan in the layout: its detail, fixed to its surface, and where its vertices are now."""

    def __init__(self, layout: Layout, shape: np.ndarray, surface: Surface | None, config: FineConfig):
        self.layout, self.shape = layout, shape
        self.mesh = layout.mesh.with_vertices(shape[layout.vertices])
        curvature, colour = raw_images(self.mesh, layout.image, surface, config)
        self.curvature: Float[np.ndarray, "h w"] = over(curvature, config.threshold)
        """1/mm, small values set to 0, for the registration error; NaN where the scan has no data."""
        self.detail = [detail(curvature, config.curvature, config.pixel_mm)]
        if colour is not None and config.colour is not None:
            self.detail.append(detail(colour, config.colour, config.pixel_mm))
        self.uv: Float[np.ndarray, "n 2"] = layout.home.copy()

    def resume(self, vertices: np.ndarray) -> None:
        """Take up the vertices of an earlier result."""
        found = closest_point(self.mesh, vertices[self.layout.vertices])
        self.uv = self.layout.place_of(found.attachment())

    def vertices(self) -> Float[np.ndarray, "n 3"]:
        """The whole scan with its vertices where they are now, mm."""
        out = self.shape.copy()
        moved = (self.uv != self.layout.home).any(axis=1)
        found = self.layout.on_surface(self.uv[moved])
        out[self.layout.vertices[moved]] = found.points(self.mesh)
        return out

    def pixels(self, points: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 2"]:
        """Where points of the scan (mm) are laid out.

        Raises:
            BadInput: a point far off the scan's face.
        """
        found = closest_point(self.mesh, points)
        if found.distances.max(initial=0) > FAR_MM:
            raise BadInput(
                f"constraints: a point is {found.distances.max():.0f} mm off the scan's face; "
                "give points on the scan, in the coordinates of its file"
            )
        return self.layout.place_of(found.attachment())

    def transported(self, points: Float[np.ndarray, "k 3"], uv: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "k 2"]:
        """Where its points come to be when its vertices go to `uv` in the image."""
        faces = self.layout.mesh.faces
        found = SurfaceImage(self.uv, faces, self.layout.shape).surface_at(self.pixels(points))
        return np.einsum("pc,pcd->pd", found.barycentric, uv[faces[found.faces]])


def prewarped(
    layout: Layout,
    scan: UnwrappedScan,
    others: list[UnwrappedScan],
    images: Callable[[UnwrappedScan], list[np.ndarray]],
) -> Float[np.ndarray, "kinds h w c"]:
    """Images of other scans where the current correspondences put them on this one; NaN where they show nothing."""
    drawn = SurfaceImage(scan.uv, layout.mesh.faces, layout.shape)
    where = drawn.draw(np.stack([other.uv for other in others], axis=1))
    known = np.isfinite(where[..., 0, 0])
    out = np.full((len(images(scan)), *layout.shape, len(others)), np.nan)
    for c, other in enumerate(others):
        for kind, image in enumerate(images(other)[: len(out)]):
            out[kind, known, c] = sampled(image, where[known][:, c])[:, 0]
    return out


def local_align(
    layout: Layout,
    scans: list[UnwrappedScan],
    i: int,
    near: Int[np.ndarray, "regions m"],
    config: FineConfig,
    constraints: Sequence[PairConstraint],
) -> Bool[np.ndarray, " regions"]:
    """Eq. 9-11 for scan i: flow per region from the neighbours' features to its own, blended, smoothed, applied.

    Gives back in which regions the flow met its tolerance; a region without evidence, which stays, did.

    The flow runs from the neighbours to the scan, so that it says of each vertex where on the scan it belongs. (From
    the scan to its neighbours, as the paper has it, its inverse would be wanted.)
    """
    scan, who = scans[i], np.unique(near)
    converged = np.ones(len(near), bool)
    if not len(who):
        return converged
    compared = compared_with(layout, scan, [scans[k] for k in who])
    held = constraints_on(scans, i, constraints, config.pixel_mm)
    offset = np.zeros((*layout.shape, 2))
    for r, members in enumerate(near):
        found = _region_flow(layout, r, compared, np.searchsorted(who, members), held, config)
        if found is not None:
            flow, converged[r] = found
            offset += layout.weights[..., r, None] * flow
    most = config.most_mm / config.pixel_mm
    if held is not None:
        most = max(most, 2 * float(np.linalg.norm(held.target - held.source, axis=1).max()))
    size = np.sqrt((offset**2).sum(axis=2, keepdims=True))
    offset = offset * (most / np.maximum(size, most))
    scan.uv = layout.moved(scan.uv, sampled(offset, scan.uv))
    return converged


@dataclass(frozen=True)
class Compared:
    """A scan beside its neighbours."""

    source: Float[np.ndarray, "kinds h w c"]
    """The neighbours' features on the scan, by kind and neighbour."""
    target: Float[np.ndarray, "kinds h w c"]
    """Its own, once for each neighbour. Both fade where one of the two shows nothing."""
    evidence: Float[np.ndarray, "h w c"]
    """0..1, what the clearest kind of detail offers."""


def compared_with(layout: Layout, scan: UnwrappedScan, others: list[UnwrappedScan]) -> Compared:
    """What the scan and the others show at the same vertices now."""
    warped = np.nan_to_num(prewarped(layout, scan, others, lambda s: [d.scaled for d in s.detail]))
    theirs = np.nan_to_num(prewarped(layout, scan, others, lambda s: [d.evidence for d in s.detail]))
    trust = np.stack([d.evidence for d in scan.detail])[..., None] * theirs
    mine = np.stack([d.scaled for d in scan.detail])[..., None]
    return Compared(warped * trust, mine * trust, trust.max(axis=0))


def _region_flow(
    layout: Layout,
    region: int,
    compared: Compared,
    members: Int[np.ndarray, " m"],
    held: FlowConstraints | None,
    config: FineConfig,
) -> tuple[Float[np.ndarray, "h w 2"], bool] | None:
    """Steps of one region, pixels, that fade away from evidence and from constraints, and whether the flow converged.

    None for no evidence.
    """
    source, target = (np.concatenate(list(x[..., members]), axis=2) for x in (compared.source, compared.target))
    mask = (layout.masks[..., region] > SHOWN) & layout.image.mask
    here = constraints_in_region(held, layout.masks[..., region])
    if not mask.any():
        return None
    evidence = np.where(mask, compared.evidence[..., members].max(axis=2), 0.0)
    if evidence.max() < LEAST and here is None:
        return None
    sigma = config.reach_mm / config.pixel_mm
    reach = np.clip(averaged(evidence, mask, sigma) / config.enough, 0, 1)
    margin = config.flow.margin
    if here is not None:
        reach = np.maximum(reach, falloff_round(here.source, layout.shape, 2 * sigma))
        margin = max(margin, int(np.abs(here.target - here.source).max()) + 8)
    box = _box(mask, margin)
    if here is not None:
        here = here.moved((box[1].start, box[0].start))
    flow = np.zeros((*layout.shape, 2))
    found = optical_flow(source[box], target[box], None, here, config.flow)
    flow[box] = found.flow
    return reach[..., None] * flow, found.converged


def _box(mask: Bool[np.ndarray, "h w"], margin: int) -> tuple[slice, slice]:
    """Rows and columns round what is to be solved. All in it counts: a mask of the source alone would bias its rim."""
    low, high = (f(np.argwhere(mask), axis=0) for f in (np.min, np.max))
    start = np.maximum(low - margin, 0)
    stop = np.minimum(np.maximum(high + 1 + margin, start + SMALLEST), mask.shape)
    start = np.maximum(np.minimum(start, stop - SMALLEST), 0)
    return slice(int(start[0]), int(stop[0])), slice(int(start[1]), int(stop[1]))
