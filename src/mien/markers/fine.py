"""Fine-scale registration of scans in one topology (Huang et al. 2011, sec. 6.2, eq. 8-11): wrinkles onto wrinkles.

Every scan is aligned, region by region, with the few scans that are closest to it there: the mean curvature of scan
and neighbours, laid out in one image, is matched by optical flow, and the scan's vertices slide along its surface.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.ndimage import distance_transform_edt

from ..errors import BadInput
from ..flow import FlowConfig, FlowConstraints, curve_constraints, optical_flow
from ..mesh import Mesh, SurfaceImage, closest_point
from ..progress import SILENT, Progress
from ..register import Surface
from .fine_features import (
    COLOUR,
    CURVATURE,
    Detail,
    FeatureConfig,
    averaged,
    colour_image,
    curvature_image,
    detail,
)
from .fine_layout import SHOWN, Layout, sampled

LEAST = 0.1
"""Evidence below which a region is left as it is."""
HOLD_MM = 1.5
"""What is said of a point holds this far round it."""


@dataclass(frozen=True)
class FineConfig:
    """How scans are aligned with their neighbours."""

    neighbours: int = 3
    """M: scans that each region of a scan is aligned with."""
    sweeps: int = 3
    """How often every scan is updated, one after the other. 0: nothing moves."""
    alpha: float = 1.0
    """Eq. 11: how much differential coordinates are kept, against the flow."""
    curvature_radius_mm: float = 2.0
    """Quadratic patches are fitted to what lies within this distance."""
    curvature: FeatureConfig = CURVATURE
    """How curvature is made comparable, 1/mm."""
    colour: FeatureConfig | None = COLOUR
    """The same for the colour of scans that have some; None: curvature alone, as in the paper."""
    reach_mm: float = 4.0
    """The flow is followed about this far beyond evidence."""
    enough: float = 0.3
    """Share of evidence nearby from which on the flow is followed in full."""
    most_mm: float = 3.0
    """Farthest that a sweep moves a vertex."""
    pixel_mm: float = 0.7
    """Side of a pixel of the layout."""
    flow: FlowConfig = field(
        default_factory=lambda: FlowConfig(margin=12, coarsest=32, smoothness=4.0, constraint=1000.0)
    )
    """Its margin is the largest displacement at least, pixels."""
    unreliable: float = 0.06
    """1/mm: a region whose features differ by more than this from its neighbours', rms, is marked."""

    def __post_init__(self):
        positive = ("neighbours", "curvature_radius_mm", "pixel_mm")
        bad = [name for name in positive if not getattr(self, name) > 0]
        bad += [name for name in ("sweeps", "alpha", "unreliable") if not getattr(self, name) >= 0]
        if bad:
            raise BadInput(f"fine registration: {', '.join(bad)} out of range; see FineConfig for what each means")


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
    moved: Float[np.ndarray, " scans"]
    """Mean distance that the vertices of the regions have slid, mm."""


@dataclass(frozen=True)
class PairConstraint:
    """Points and curves that are the same on two scans; face space, mm."""

    scans: tuple[int, int]
    points: tuple[Float[np.ndarray, "k 3"], Float[np.ndarray, "k 3"]]
    """On the one and on the other."""
    curves: tuple[tuple[Float[np.ndarray, "p 3"], Float[np.ndarray, "q 3"]], ...] = ()
    """Pairs of polylines, from end to end."""


def register_fine(
    shapes: Float[np.ndarray, "scans n 3"],
    faces: Int[np.ndarray, "m 3"],
    regions: dict[str, Float[np.ndarray, " n"]],
    surfaces: Sequence[Surface] | None = None,
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
        surfaces: the scans themselves in that frame: curvature and colour are then theirs, not those of `shapes`.
        only: scans to redo, None for all; the others stay as they are in `start`.
        start: the vertices of an earlier result; the scans to redo begin anew.

    Raises:
        BadInput: arrays that do not fit each other, or a scan number that is not there.
    """
    _check(shapes, regions, surfaces, constraints, only)
    layout = Layout(Mesh(shapes.mean(axis=0), faces), regions, config.pixel_mm, config.alpha)
    sheets = [_Sheet(layout, x, surfaces[i] if surfaces else None, config) for i, x in enumerate(shapes)]
    chosen = range(len(shapes)) if only is None else sorted(set(only))
    if start is not None:
        for i in sorted(set(range(len(shapes))) - set(chosen)):
            sheets[i].resume(start[i])
    near = closest_scans(shapes, regions, config.neighbours)
    before = _errors(layout, sheets, near)
    for sweep in range(config.sweeps):
        for count, i in enumerate(chosen):
            _local_align(layout, sheets, i, near[i], config, constraints)
            progress.update("aligning wrinkles", sweep * len(chosen) + count + 1, config.sweeps * len(chosen))
    vertices = shapes.copy() if start is None else start.copy()
    for i in chosen:
        vertices[i] = sheets[i].vertices()
    errors = _errors(layout, sheets, near)
    moved = np.linalg.norm(vertices - shapes, axis=2)[:, layout.vertices].mean(axis=1)
    return FineResult(vertices, errors, before, errors > config.unreliable, near, moved)


def closest_scans(
    shapes: Float[np.ndarray, "scans n 3"], regions: dict[str, Float[np.ndarray, " n"]], count: int
) -> Int[np.ndarray, "scans regions m"]:
    """For every scan and region the `count` scans closest to it there, closest first; fewer if there are no more.

    The distance is rms over the region's vertices after the best rigid motion between the two.
    """
    scans = len(shapes)
    out = np.empty((scans, len(regions), min(count, scans - 1)), np.int64)
    for r, mask in enumerate(regions.values()):
        used = mask > 0.05
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


class _Sheet:
    """One scan in the layout: its detail, fixed to its surface, and where its vertices are now."""

    def __init__(self, layout: Layout, shape: np.ndarray, surface: Surface | None, config: FineConfig):
        self.layout, self.shape = layout, shape
        self.mesh = layout.mesh.with_vertices(shape[layout.vertices])
        curvature = curvature_image(self.mesh, layout.image, surface, config.curvature_radius_mm)
        self.detail = [detail(curvature, config.curvature, config.pixel_mm)]
        colour = colour_image(self.mesh, layout.image, surface)
        if colour is not None and config.colour is not None:
            self.detail.append(detail(colour, config.colour, config.pixel_mm))
        self.places: Float[np.ndarray, "n 2"] = layout.home.copy()

    def resume(self, vertices: np.ndarray) -> None:
        """Take up the vertices of an earlier result."""
        found = closest_point(self.mesh, vertices[self.layout.vertices])
        self.places = self.layout.place_of(found.attachment())

    def vertices(self) -> Float[np.ndarray, "n 3"]:
        """The whole scan with its vertices where they are now, mm."""
        out = self.shape.copy()
        moved = (self.places != self.layout.home).any(axis=1)
        found = self.layout.on_surface(self.places[moved])
        out[self.layout.vertices[moved]] = found.points(self.mesh)
        return out

    def pixels(self, points: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "k 2"]:
        """Where points of the scan (mm) are laid out."""
        return self.layout.place_of(closest_point(self.mesh, points).attachment())

    def carried(self, points: Float[np.ndarray, "k 3"], other: "_Sheet") -> Float[np.ndarray, "k 2"]:
        """Where the current correspondences put points of this scan in the image of another."""
        drawn = SurfaceImage(self.places, self.layout.mesh.faces, self.layout.shape)
        found = drawn.surface_at(self.pixels(points))
        return np.einsum("pc,pcd->pd", found.barycentric, other.places[self.layout.mesh.faces[found.faces]])


def _prewarped(
    layout: Layout, sheet: _Sheet, others: list[_Sheet], what: Callable[[Detail], np.ndarray]
) -> list[Float[np.ndarray, "h w c"]]:
    """`what` of each kind of the others' detail, where the current correspondences put it on the scan."""
    drawn = SurfaceImage(sheet.places, layout.mesh.faces, layout.shape)
    where = drawn.draw(np.stack([other.places for other in others], axis=1))
    known = np.isfinite(where[..., 0, 0])
    out = []
    for kind in range(len(sheet.detail)):
        image = np.full((*layout.shape, len(others)), np.nan)
        for c, other in enumerate(others):
            image[known, c] = sampled(what(other.detail[kind]), where[known][:, c])[:, 0]
        out.append(image)
    return out


def _local_align(
    layout: Layout,
    sheets: list[_Sheet],
    i: int,
    near: Int[np.ndarray, "regions m"],
    config: FineConfig,
    constraints: Sequence[PairConstraint],
) -> None:
    """Eq. 9-11 for scan i: flow per region from the neighbours' features to its own, blended, smoothed, applied.

    The flow runs from the neighbours to the scan, so that it says of each vertex where on the scan it belongs. (From
    the scan to its neighbours, as the paper has it, its inverse would be wanted.)
    """
    sheet, who = sheets[i], np.unique(near)
    compared = _compared(layout, sheet, [sheets[k] for k in who])
    held = _held(sheets, i, constraints, config.pixel_mm)
    offset = np.zeros((*layout.shape, 2))
    for r, members in enumerate(near):
        flow = _region_flow(layout, r, compared, np.searchsorted(who, members), held, config)
        if flow is not None:
            offset += layout.weights[..., r, None] * flow
    most = config.most_mm / config.pixel_mm
    if held is not None:
        most = max(most, 2 * float(np.linalg.norm(held.target - held.source, axis=1).max()))
    size = np.sqrt((offset**2).sum(axis=2, keepdims=True))
    offset = offset * (most / np.maximum(size, most))
    sheet.places = layout.moved(sheet.places, sampled(offset, sheet.places))


@dataclass(frozen=True)
class _Compared:
    """A scan beside its neighbours."""

    source: Float[np.ndarray, "kinds h w c"]
    """The neighbours' features on the scan, by kind and neighbour."""
    target: Float[np.ndarray, "kinds h w c"]
    """Its own, once for each neighbour. Both fade where one of the two shows nothing."""
    evidence: Float[np.ndarray, "h w c"]
    """0..1, what the clearest kind of detail offers."""


def _compared(layout: Layout, sheet: _Sheet, others: list[_Sheet]) -> _Compared:
    warped = _prewarped(layout, sheet, others, lambda d: d.scaled)
    theirs = _prewarped(layout, sheet, others, lambda d: d.evidence)
    pairs = zip(sheet.detail, theirs, strict=True)
    trust = np.nan_to_num(np.stack([mine.evidence[..., None] * their for mine, their in pairs]))
    mine = np.stack([d.scaled for d in sheet.detail])[..., None]
    return _Compared(np.stack(warped) * trust, mine * trust, trust.max(axis=0))


def _region_flow(
    layout: Layout,
    region: int,
    compared: _Compared,
    members: Int[np.ndarray, " m"],
    held: FlowConstraints | None,
    config: FineConfig,
) -> Float[np.ndarray, "h w 2"] | None:
    """Steps of one region, pixels, that fade away from evidence and from constraints; None for no evidence."""
    source, target = (np.concatenate(list(x[..., members]), axis=2) for x in (compared.source, compared.target))
    mask = (layout.masks[..., region] > SHOWN) & np.isfinite(source).all(axis=2)
    here = _within(held, layout.masks[..., region])
    if not mask.any():
        return None
    evidence = np.where(mask, compared.evidence[..., members].max(axis=2), 0.0)
    if evidence.max() < LEAST and here is None:
        return None
    settings = config.flow
    sigma = config.reach_mm / config.pixel_mm
    reach = np.clip(averaged(evidence, mask, sigma) / config.enough, 0, 1)
    if here is not None:
        far = np.linalg.norm(here.target - here.source, axis=1).max()
        settings = replace(settings, margin=max(settings.margin, int(far) + 8))
        reach = np.maximum(reach, _round(here.source, layout.shape, 2 * sigma))
    flow = optical_flow(source, target, mask, here, settings).flow
    return reach[..., None] * flow


def _round(points: Float[np.ndarray, "k 2"], shape: tuple[int, int], sigma: float) -> Float[np.ndarray, "h w"]:
    """1 at image points, falling off over `sigma` pixels."""
    away = np.ones(shape, bool)
    x, y = np.clip(np.round(points).astype(int), 0, [shape[1] - 1, shape[0] - 1]).T
    away[y, x] = False
    return np.exp(-0.5 * (distance_transform_edt(away) / sigma) ** 2)


def _within(held: FlowConstraints | None, mask: Float[np.ndarray, "h w"]) -> FlowConstraints | None:
    """Those constraints that start in a region."""
    if held is None:
        return None
    inside = sampled(mask, held.source)[:, 0] > SHOWN
    if not inside.any():
        return None
    across = None if held.across is None else held.across[inside]
    return FlowConstraints(held.source[inside], held.target[inside], across)


def _held(
    sheets: list[_Sheet], i: int, constraints: Sequence[PairConstraint], pixel_mm: float
) -> FlowConstraints | None:
    """What is known of scan i: where in its image the vertices under the other scan's points are, and belong."""
    found: FlowConstraints | None = None
    radius = HOLD_MM / pixel_mm
    for constraint in constraints:
        if i not in constraint.scans:
            continue
        me = constraint.scans.index(i)
        other = sheets[constraint.scans[1 - me]]
        parts = []
        if len(constraint.points[0]):
            source = other.carried(constraint.points[1 - me], sheets[i])
            parts.append(FlowConstraints(source, sheets[i].pixels(constraint.points[me])))
        for curve in constraint.curves:
            source = other.carried(_dense(curve[1 - me]), sheets[i])
            parts.append(curve_constraints(source, sheets[i].pixels(_dense(curve[me])), spacing=2.0))
        for part in parts:
            part = _spread(part, radius)
            found = part if found is None else found + part
    return found


def _spread(held: FlowConstraints, radius: float) -> FlowConstraints:
    """The same displacements on a disc round each point, so that smoothing does not take them away."""
    grid = np.arange(-np.ceil(radius), np.ceil(radius) + 1)
    around = np.stack(np.meshgrid(grid, grid), -1).reshape(-1, 2)
    around = around[np.linalg.norm(around, axis=1) <= radius]
    source, target = ((x[:, None] + around).reshape(-1, 2) for x in (held.source, held.target))
    across = np.zeros_like(held.source) if held.across is None else held.across
    return FlowConstraints(source, target, np.repeat(across, len(around), axis=0))


def _dense(line: Float[np.ndarray, "p 3"], spacing: float = 1.0) -> Float[np.ndarray, "q 3"]:
    """A polyline with points every `spacing` mm."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.linspace(0, length[-1], max(2, 1 + int(np.ceil(length[-1] / spacing))))
    return np.stack([np.interp(at, length, line[:, d]) for d in range(3)], 1)


def _errors(layout: Layout, sheets: list[_Sheet], near: np.ndarray) -> Float[np.ndarray, "scans regions"]:
    """Rms difference of the curvature features from the neighbours', over each region, 1/mm."""
    out = np.zeros(near.shape[:2])
    for i, sheet in enumerate(sheets):
        who = np.unique(near[i])
        if not len(who):
            continue
        warped = _prewarped(layout, sheet, [sheets[k] for k in who], lambda d: d.values)[0]
        squared = (warped - sheet.detail[0].values[..., None]) ** 2
        for r, members in enumerate(near[i]):
            part = squared[..., np.searchsorted(who, members)]
            known = np.isfinite(part)
            weight = layout.masks[..., r, None] * known
            out[i, r] = np.sqrt((np.where(known, part, 0) * weight).sum() / max(weight.sum(), 1e-12))
    return out


def _check(shapes, regions, surfaces, constraints, only) -> None:
    n = shapes.shape[1]
    if not regions:
        raise BadInput("fine registration: no regions are given; at least one is needed")
    wrong = [name for name, mask in regions.items() if mask.shape != (n,)]
    if wrong:
        raise BadInput(f"fine registration: region {wrong[0]} must have one value for each of the {n} vertices")
    if surfaces is not None and len(surfaces) != len(shapes):
        raise BadInput(f"fine registration: {len(surfaces)} surfaces for {len(shapes)} scans; give one each")
    if not all(0 <= i < len(shapes) for c in constraints for i in c.scans):
        raise BadInput(f"fine registration: constraints must name scans from 0 to {len(shapes) - 1}")
    if only is not None and not all(0 <= i < len(shapes) for i in only):
        raise BadInput(f"fine registration: scans to redo must be numbers from 0 to {len(shapes) - 1}")
