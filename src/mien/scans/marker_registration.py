"""Markers on a scan of the same expression: marker mesh registration (Huang et al. 2011, sec. 5, eq. 4-6).

What is ours, where the paper is silent: each marker stands off the skin by a distance of its own, the same on all
scans; the mix of expressions is held near the one that was asked for, as far as actors usually miss it, since a closest
point says nothing of where along the skin a marker is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from ..mesh import Attachment
from ..register import Rejection, Surface
from ..transforms import Transform
from .marker_pose import MarkerPose, MarkerPoseConfig, ScannedFrame, marker_pairs, rigid_fit, signed_heights

COVERED_MM = 3.0
"""A marker farther than this from its stand-off has no skin under it: hair, or the wrong layer."""
SETTLED_MM = 1e-3
"""A step of the mix that moves no marker by more than this ends the rounds."""
RIDGE = 1e-9
"""Of the mix's weights, so that equal expressions do not make the system singular."""


@dataclass(frozen=True)
class MarkerRegistrationConfig:
    """How markers are laid on scans. Millimetres throughout."""

    pose: MarkerPoseConfig = field(default_factory=MarkerPoseConfig)
    rounds: int = 15
    """Closest-point rounds of the nonrigid step."""
    performance_sigma: float = 1.0
    """How far the performed expression is expected to be from the one asked for, rms at a marker."""
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
    config: MarkerRegistrationConfig = MarkerRegistrationConfig(),
) -> MarkersOnScans:
    """Every selected frame's markers on the scan of the same expression, from the poses that `find_poses` gave."""
    surfaces = [Surface(frame.mesh) for frame in frames]
    expressions = np.stack([frame.markers for frame in frames])
    standoff = np.full(expressions.shape[1], float(np.median([pose.rise for pose in poses])))
    found = _both_steps(expressions, surfaces, [pose.T_scan_head for pose in poses], standoff, config)
    for _ in range(config.standoff_rounds):
        standoff = _own_standoff(found, standoff)
        found = _both_steps(expressions, surfaces, [f.T_head_scan.inverse() for f in found], standoff, config)
    return MarkersOnScans(tuple(found), standoff)


def _both_steps(
    expressions: Float[np.ndarray, "scans markers 3"],
    surfaces: list[Surface],
    T_scan_head: list[Transform],
    standoff: Float[np.ndarray, " markers"],
    config: MarkerRegistrationConfig,
) -> list[MarkersOnScan]:
    found = []
    for i, (surface, start) in enumerate(zip(surfaces, T_scan_head, strict=True)):
        pose = rigid_fit(expressions[i], surface, start, standoff, config.pose)
        found.append(nonrigid_fit(expressions, i, surface, pose.T_scan_head, standoff, config))
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
    config: MarkerRegistrationConfig = MarkerRegistrationConfig(),
) -> MarkersOnScan:
    """Eq. 6: the mix of the selected expressions whose markers meet the scan, by closest points.

    Minimises |distances across the surface|^2 / noise^2 + |mix - own|^2 / performance_sigma^2, the latter at the
    markers; the mix adds up to 1, since the rigid step has settled the size.
    """
    reference = expressions[own]
    modes = np.delete(expressions, own, axis=0) - reference
    rigid = marker_pairs(T_scan_head.apply(reference), surface, standoff, config.pose)
    mix = _solved_mix(reference, modes, surface, T_scan_head, standoff, config)
    moved = reference + np.tensordot(mix, modes, axes=1)
    found = surface.correspond(T_scan_head.apply(moved), rejection=Rejection())
    above = signed_heights(T_scan_head.apply(moved), found) - standoff
    believed = rigid.heights[rigid.weights > 0]
    return MarkersOnScan(
        T_head_scan=T_scan_head.inverse(),
        attachment=found.attachment(),
        markers=moved,
        expression_weights=np.insert(mix, own, 1 - mix.sum()),
        height_residual=above,
        rigid_rms=float(np.sqrt((believed**2).mean())) if len(believed) else float("nan"),
        covered=found.accepted & (np.abs(above) < COVERED_MM),
    )


def _solved_mix(
    reference: Float[np.ndarray, "markers 3"],
    modes: Float[np.ndarray, "modes markers 3"],
    surface: Surface,
    T_scan_head: Transform,
    standoff: Float[np.ndarray, " markers"],
    config: MarkerRegistrationConfig,
) -> Float[np.ndarray, " modes"]:
    """Weights of the other expressions, by Gauss-Newton over closest points."""
    count, markers, _ = modes.shape
    turned = T_scan_head.rotate(modes.reshape(-1, 3)).reshape(modes.shape)
    flat = modes.reshape(count, 3 * markers)
    prior = (flat @ flat.T) / config.performance_sigma**2 + RIDGE * np.eye(count)
    mix = np.zeros(count)
    for _ in range(config.rounds):
        x = T_scan_head.apply(reference + np.tensordot(mix, modes, axes=1))
        pairs = marker_pairs(x, surface, standoff, config.pose)
        J = np.einsum("kmd,md->mk", turned, pairs.normals)
        w = pairs.weights / config.pose.noise**2
        gram = J.T @ (w[:, None] * J) + prior
        step = np.linalg.solve(gram, -(J.T @ (w * pairs.heights)) - prior @ mix)
        mix = mix + step
        if np.abs(np.tensordot(step, modes, axes=1)).max(initial=0.0) < SETTLED_MM:
            break
    return mix
