"""A frame's markers on a scan, rigidly (Huang et al. 2011, sec. 5, eq. 5), and where to start.

What is ours, where the paper is silent: markers stand off the skin by a distance that is found with the pose; bad
closest points are left out; of several starts the one is taken that leaves least *after* the stand-off is known, and
where the scans' own faces are known, one pose of the take's head must serve them all.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..mesh import ClosestPoint, Mesh
from ..mesh.cluster import clustered
from ..register import Correspondences, Rejection, Surface
from ..register.align import AlignConfig, align
from ..register.rigid_icp import closest_point_rounds, plane_system
from ..transforms import Transform
from .left_out import LeftOut

ROBUST_SIGMA = 1.4826
"""A normal distribution's standard deviation, in median absolute deviations."""
SETTLED_MM = 1e-4
"""A round that moves no marker by more ends them."""
DISTINCT_MM = 15.0
"""Starts that bring the markers as near as this, in the mean, are one."""


@dataclass(frozen=True)
class MarkerPoseConfig:
    """How a frame's markers are brought onto a scan. Millimetres throughout."""

    start_cell: float = 6.0
    """The scan is thinned to about this spacing while starts are looked for."""
    clear: float = 0.6
    """A start by shape alone is sure where its misfit is at most this share of the next different one's."""
    most: float = 3.0
    """... and no start may leave more than this."""
    keep: float = 0.85
    """Share of the markers, the closest ones, that a misfit is taken over: hair and holes hide the others."""
    witnesses: int = 4
    """Scans on which a pose of the head is tried before it is believed."""
    rounds: int = 30
    """Closest-point rounds."""
    outlier: float = 3.0
    """Distances beyond this many times their robust spread count for less and less."""
    noise: float = 0.15
    """Markers' and scan's noise across the surface."""
    standoff_most: float = 8.0
    """Marker centres are on the skin or up to so far above it."""


@dataclass(frozen=True)
class MarkerPose:
    """A frame's markers on a scan, as a rigid body."""

    T_scan_head: Transform
    """Head frame of the take -> the scan's frame, mm."""
    rise: float
    """Height of the markers above the skin beyond the stand-offs given, the same for all, mm."""
    misfit: float
    """Root mean square of what is left at the closest markers, mm."""


def rigid_fit(
    markers: Float[np.ndarray, "markers 3"],
    surface: Surface,
    start: Transform,
    standoff: Float[np.ndarray, " markers"],
    config: MarkerPoseConfig = MarkerPoseConfig(),
    rise: bool = False,
) -> MarkerPose:
    """Eq. 5 by point-to-plane ICP from `start` (T_scan_head); with `rise` a common height above the skin too."""
    above = -np.ones((len(markers), 1)) if rise else None

    def one_round(now: tuple[Transform, float]) -> tuple[tuple[Transform, float], bool]:
        T, more = now
        x = T.apply(markers)
        pairs = marker_pairs(x, surface, standoff + more, config)
        step, higher = plane_system(x, pairs.normals, -pairs.heights, pairs.weights, above).solve()
        more = float(np.clip(more + higher.sum(), 0.0, config.standoff_most))
        still = np.abs(step.apply(x) - x).max() < SETTLED_MM and np.abs(higher).max(initial=0.0) < SETTLED_MM
        return (step @ T, more), bool(still)

    T, more = closest_point_rounds((start, 0.0), one_round, config.rounds).state
    return MarkerPose(T, more, misfit(T.apply(markers), surface, standoff + more, config))


@dataclass(frozen=True)
class MarkerPairs:
    """Markers and the skin under them, one row a marker."""

    normals: Float[np.ndarray, "markers 3"]
    """The skin's."""
    weights: Float[np.ndarray, " markers"]
    """0..1: how far each closest point is believed."""
    heights: Float[np.ndarray, " markers"]
    """Distance from the skin beyond the stand-off, mm; negative below."""


def marker_pairs(
    x: Float[np.ndarray, "markers 3"], surface: Surface, standoff: np.ndarray, config: MarkerPoseConfig
) -> MarkerPairs:
    """Closest points under markers at `x` (the scan's frame, mm), robustly weighted."""
    found = surface.correspond(x, rejection=Rejection())
    above = signed_heights(x, found) - standoff
    sigma = ROBUST_SIGMA * np.median(np.abs(above[found.accepted])) if found.accepted.any() else 1.0
    scale = config.outlier * max(sigma, config.noise)
    return MarkerPairs(found.normals, found.accepted / (1 + (above / scale) ** 2) ** 2, above)


def signed_heights(x: Float[np.ndarray, "markers 3"], found: Correspondences) -> Float[np.ndarray, " markers"]:
    """Distance of each marker from the skin, positive outside, mm."""
    return np.einsum("md,md->m", x - found.points, found.normals)


def misfit(
    x: Float[np.ndarray, "markers 3"], surface: Surface, standoff: np.ndarray, config: MarkerPoseConfig
) -> float:
    """Rms of what is left at the closest share of the markers, mm; beyond a rim the whole distance is left."""
    found = surface.correspond(x, rejection=Rejection())
    left = np.where(found.accepted, signed_heights(x, found) - standoff, found.distances)
    near = np.sort(left**2)[: max(4, round(config.keep * len(x)))]
    return float(np.sqrt(near.mean()))


def starts_by_shape(
    markers: Float[np.ndarray, "markers 3"], surface: Surface, config: MarkerPoseConfig = MarkerPoseConfig()
) -> list[MarkerPose]:
    """Distinct poses from the shape alone, the one that leaves least first: trimmed closest points from many turns.

    Each is refined with the stand-off free before they are compared: markers that stand 2 mm off the skin leave 2 mm
    in the right place too.
    """
    thin = ClosestPoint(clustered(surface.mesh, config.start_cell))
    rough = align(markers, thin, AlignConfig(scale_range=0.0, distinct_mm=DISTINCT_MM, keep=config.keep))
    nowhere = np.zeros(len(markers))
    fits = [rigid_fit(markers, surface, found.T_face_head, nowhere, config, rise=True) for found in rough]
    distinct: list[MarkerPose] = []
    for fit in sorted(fits, key=lambda fit: fit.misfit):
        placed = fit.T_scan_head.apply(markers)
        if all(_apart(placed, other.T_scan_head.apply(markers)) > DISTINCT_MM for other in distinct):
            distinct.append(fit)
    return distinct


def _apart(placed: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(placed - other, axis=1).mean())


@dataclass(frozen=True)
class ScannedFrame:
    """A scan and the markers of its frame."""

    name: str
    markers: Float[np.ndarray, "markers 3"]
    """Head frame of the take, mm."""
    mesh: Mesh
    """The scan's surface, its own frame, mm."""
    T_face_scan: Transform | None
    """Rigid: where its own landmarks put its face; None where no face was found."""


def head_on_face(frame: ScannedFrame, pose: MarkerPose) -> Transform | None:
    """T_face_head of a scan whose own face is known."""
    return None if frame.T_face_scan is None else frame.T_face_scan @ pose.T_scan_head


def find_poses(
    frames: Sequence[ScannedFrame], config: MarkerPoseConfig = MarkerPoseConfig()
) -> list[MarkerPose | LeftOut]:
    """Every frame's markers on its scan, with a common height above the skin; the neutral one comes first.

    The neutral scan is tried from its shape alone. Where its face is known, each way to lay the markers on it is a pose
    of the take's head against the face, and so a start on every other scan whose face is known: the way that leaves
    least over all of them is taken. Scans without a known face are started from their shape.
    """
    surfaces = [Surface(frame.mesh) for frame in frames]
    level = np.zeros(len(frames[0].markers))
    neutral, ways = frames[0], starts_by_shape(frames[0].markers, surfaces[0], config)
    if neutral.T_face_scan is not None:
        misfits = [_common_misfit(neutral.T_face_scan @ way.T_scan_head, frames, surfaces, config) for way in ways]
        best = [ways[int(np.argmin(misfits))]] if len(misfits) else []
        ways = [rigid_fit(neutral.markers, surfaces[0], way.T_scan_head, level, config, rise=True) for way in best]
    found = [_judged(neutral.name, ways, config)]
    T_face_head = head_on_face(neutral, ways[0]) if ways else None
    for frame, surface in zip(frames[1:], surfaces[1:], strict=True):
        tried = _from_face(frame, surface, T_face_head, config)
        if not tried or tried[0].misfit > config.most:
            tried = starts_by_shape(frame.markers, surface, config)
        found.append(_judged(frame.name, tried, config))
    return found


def _from_face(
    frame: ScannedFrame, surface: Surface, T_face_head: Transform | None, config: MarkerPoseConfig
) -> list[MarkerPose]:
    """The markers where the scan's own face says they are; none where one of the two is not known."""
    if frame.T_face_scan is None or T_face_head is None:
        return []
    start = frame.T_face_scan.inverse() @ T_face_head
    return [rigid_fit(frame.markers, surface, start, np.zeros(len(frame.markers)), config, rise=True)]


def _common_misfit(
    T_face_head: Transform, frames: Sequence[ScannedFrame], surfaces: Sequence[Surface], config: MarkerPoseConfig
) -> float:
    """What a pose of the head leaves on the first few scans whose face is known, mean, mm."""
    witnesses = [i for i, frame in enumerate(frames) if frame.T_face_scan is not None][: config.witnesses]
    left = [_from_face(frames[i], surfaces[i], T_face_head, config)[0].misfit for i in witnesses]
    return float(np.mean(left))


def _judged(name: str, ways: Sequence[MarkerPose], config: MarkerPoseConfig) -> MarkerPose | LeftOut:
    """The best of the ways, best first, if it fits and no other fits nearly as well."""
    if not ways or ways[0].misfit > config.most:
        left = f"{ways[0].misfit:.1f} mm are left" if ways else "no start was found"
        return LeftOut(name, f"the markers of its frame do not fit the scan ({left}); is it the right scan and unit?")
    if len(ways) > 1 and ways[0].misfit > config.clear * ways[1].misfit:
        both = f"{ways[0].misfit:.1f} and {ways[1].misfit:.1f} mm"
        return LeftOut(name, f"the markers fit the scan in two ways ({both}); crop the scan to the face")
    return ways[0]
