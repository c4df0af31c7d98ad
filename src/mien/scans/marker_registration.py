"""Markers on a scan of the same expression: marker mesh registration (Huang et al. 2011, sec. 5, eq. 4-6).

What is ours, where the paper is silent: each marker stands off the skin by a distance of its own, the same on all
scans; what an actor played otherwise is a little of the other expressions and a little of the bundled shapes, each held
near none, since a closest point says nothing of where along the skin a marker is; and it is told together with the
pose, which would else turn the head to meet a jaw that is more open.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float

from ..mesh import Attachment
from ..register import Rejection, Surface
from ..register.rigid_icp import closest_point_rounds, plane_system
from ..transforms import Transform
from .marker_pose import MarkerPose, MarkerPoseConfig, ScannedFrame, marker_pairs, rigid_fit, signed_heights

COVERED_MM = 3.0
"""A marker farther than this from its stand-off has no skin under it: hair, or the wrong layer."""
SETTLED_MM = 1e-3
"""A step that moves no marker by more than this ends the rounds."""


@dataclass(frozen=True)
class MarkerRegistrationConfig:
    """How markers are laid on scans. Millimetres throughout."""

    pose: MarkerPoseConfig = field(default_factory=MarkerPoseConfig)
    rounds: int = 15
    """Closest-point rounds of the nonrigid step."""
    mix_deviation: float = 0.1
    """How much of each other expression an actor is expected to play besides, as a weight; 0: none."""
    shape_deviation: float = 0.05
    """... and of each of the bundled face's shapes; 0: none, as in the paper."""
    standoff_rounds: int = 2
    """Rounds in which each marker finds its own stand-off from all scans."""


@dataclass(frozen=True)
class MarkersOnScan:
    """Where the markers are on one scan."""

    T_head_scan: Transform
    """Rigid: the scan's frame -> head frame of the take, mm."""
    attachment: Attachment
    """On the scan's mesh: the points of the skin under the markers."""
    markers: Float[np.ndarray, "markers 3"]
    """The frame's markers after the nonrigid step, head frame, mm."""
    expression_weights: Float[np.ndarray, " expressions"]
    """w of eq. 6; 1 for the scan's own frame and 0 elsewhere is the expression that was asked for."""
    height_residual: Float[np.ndarray, " markers"]
    """What is left between marker and skin beyond the stand-off, mm; positive above it."""
    rigid_rms: float
    """The same after the rigid step alone, rms, mm."""
    covered: Bool[np.ndarray, " markers"]
    """False where the scan has no surface under a marker: hair, a hole, beyond the rim."""


@dataclass(frozen=True)
class MarkersOnScans:
    """All markers on all scans."""

    scans: tuple[MarkersOnScan, ...]
    standoff: Float[np.ndarray, " markers"]
    """Height of each marker's centre above the skin, mm, the same on all scans."""


def fit_markers_to_scans(
    frames: Sequence[ScannedFrame],
    poses: Sequence[MarkerPose],
    shapes: Float[np.ndarray, "shapes markers 3"],
    config: MarkerRegistrationConfig = MarkerRegistrationConfig(),
) -> MarkersOnScans:
    """Every selected frame's markers on the scan of the same expression, from the poses that `find_poses` gave.

    Stand-offs are found without the shapes, which would take a part of them for a jaw or cheeks that are elsewhere.

    Args:
        shapes: how the bundled face's shapes move each marker, head frame, mm; none where they are not known.
    """
    surfaces = [Surface(frame.mesh) for frame in frames]
    expressions = np.stack([frame.markers for frame in frames])
    standoff = np.full(expressions.shape[1], float(np.median([pose.rise for pose in poses])))
    T_scan_head, none = [pose.T_scan_head for pose in poses], shapes[:0]
    for _ in range(config.standoff_rounds):
        found = _both_steps(expressions, surfaces, T_scan_head, standoff, none, config)
        T_scan_head = [f.T_head_scan.inverse() for f in found]
        standoff = _own_standoff(found, standoff)
    found = _both_steps(expressions, surfaces, T_scan_head, standoff, shapes, config)
    return MarkersOnScans(tuple(found), standoff)


def _both_steps(
    expressions: Float[np.ndarray, "scans markers 3"],
    surfaces: list[Surface],
    T_scan_head: list[Transform],
    standoff: Float[np.ndarray, " markers"],
    shapes: Float[np.ndarray, "shapes markers 3"],
    config: MarkerRegistrationConfig,
) -> list[MarkersOnScan]:
    found = []
    for i, (surface, start) in enumerate(zip(surfaces, T_scan_head, strict=True)):
        pose = rigid_fit(expressions[i], surface, start, standoff, config.pose)
        found.append(nonrigid_fit(expressions, i, surface, pose.T_scan_head, standoff, shapes, config))
    return found


def _own_standoff(found: list[MarkersOnScan], standoff: np.ndarray) -> Float[np.ndarray, " markers"]:
    """Each marker's stand-off moved by what it is off on the average scan, as far as the scans are many."""
    off = np.stack([np.where(f.covered, f.height_residual, 0.0) for f in found])
    count = np.stack([f.covered for f in found]).sum(axis=0)
    return np.maximum(standoff + off.sum(axis=0) / (count + 1), 0.0)


def nonrigid_fit(
    expressions: Float[np.ndarray, "expressions markers 3"],
    own: int,
    surface: Surface,
    T_scan_head: Transform,
    standoff: Float[np.ndarray, " markers"],
    shapes: Float[np.ndarray, "shapes markers 3"],
    config: MarkerRegistrationConfig = MarkerRegistrationConfig(),
) -> MarkersOnScan:
    """Eq. 6: pose, mix of the selected expressions and weights of shapes whose markers meet the scan.

    Minimises |distances across the surface|^2 / noise^2 + |weights / deviation|^2 by closest points. The mix adds up
    to 1, since scan and markers have one size.

    Args:
        shapes: as in `fit_markers_to_scans`.
    """
    reference = expressions[own]
    others = np.delete(expressions, own, axis=0) - reference
    deviation = np.repeat([config.mix_deviation, config.shape_deviation], [len(others), len(shapes)])
    used = deviation > 0
    modes = np.concatenate([others, shapes])
    rigid = marker_pairs(T_scan_head.apply(reference), surface, standoff, config.pose)
    start = _Played(T_scan_head, reference, np.zeros(used.sum()), modes[used])
    played = _solved(start, deviation[used], surface, standoff, config)
    weights = np.zeros(len(modes))
    weights[used] = played.weights
    mix = weights[: len(others)]
    found = surface.correspond(played.in_scan, rejection=Rejection())
    above = signed_heights(played.in_scan, found) - standoff
    believed = rigid.heights[rigid.weights > 0]
    return MarkersOnScan(
        T_head_scan=played.T_scan_head.inverse(),
        attachment=found.attachment(),
        markers=played.markers,
        expression_weights=np.insert(mix, own, 1 - mix.sum()),
        height_residual=above,
        rigid_rms=float(np.sqrt((believed**2).mean())) if len(believed) else float("nan"),
        covered=found.accepted & (np.abs(above) < COVERED_MM),
    )


@dataclass(frozen=True)
class _Played:
    """Markers in a pose, and what is played besides the expression that was asked for."""

    T_scan_head: Transform
    reference: Float[np.ndarray, "markers 3"]
    weights: Float[np.ndarray, " modes"]
    modes: Float[np.ndarray, "modes markers 3"]

    @property
    def markers(self) -> Float[np.ndarray, "markers 3"]:
        """Head frame, mm."""
        return self.reference + np.tensordot(self.weights, self.modes, axes=1)

    @property
    def in_scan(self) -> Float[np.ndarray, "markers 3"]:
        """The scan's frame, mm."""
        return self.T_scan_head.apply(self.markers)


def _solved(
    start: _Played,
    deviation: Float[np.ndarray, " modes"],
    surface: Surface,
    standoff: Float[np.ndarray, " markers"],
    config: MarkerRegistrationConfig,
) -> _Played:
    """Pose and weights, by Gauss-Newton over closest points."""
    prior = (config.pose.noise / deviation) ** 2

    def one_round(now: _Played) -> tuple[_Played, bool]:
        x = now.in_scan
        pairs = marker_pairs(x, surface, standoff, config.pose)
        turned = now.T_scan_head.rotate(now.modes.reshape(-1, 3)).reshape(now.modes.shape)
        columns = np.einsum("kmd,md->mk", turned, pairs.normals)
        system = plane_system(x, pairs.normals, -pairs.heights, pairs.weights, columns)
        step, more = system.held(now.weights, prior).solve()
        then = replace(now, T_scan_head=step @ now.T_scan_head, weights=now.weights + more)
        return then, bool(np.abs(then.in_scan - x).max() < SETTLED_MM)

    return closest_point_rounds(start, one_round, config.rounds).state
