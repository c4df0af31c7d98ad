"""Does the take know depth? A single camera's does not, whatever its file says."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..transforms import Transform


@dataclass(frozen=True)
class DepthConfig:
    """When depth counts as measured."""

    least_share: float = 0.08
    """Share of a marker's motion that is along the take's flattest direction and that its motion across leaves open."""
    weight: float = 0.01
    """What a squared millimetre of depth counts for where depth is no measurement; 1 trusts it all the same."""


@dataclass(frozen=True)
class DepthMetric:
    """How much each direction of the lab is worth."""

    metric: Float[np.ndarray, "3 3"]
    """Identity, or small along the depth axis."""
    known: bool
    """Whether depth was measured."""
    share: float
    """The figure it was judged by: median unexplained share of the depth motion."""

    def in_face_space(self, T_lab_face: Transform) -> Float[np.ndarray, "3 3"]:
        """The metric turned into face space, by the take's mean head pose."""
        u, _, vt = np.linalg.svd(T_lab_face.rotation.mean(axis=0))
        R = u @ vt
        return R.T @ self.metric @ R


def depth_metric(
    positions: Float[np.ndarray, "frames markers 3"], config: DepthConfig = DepthConfig()
) -> DepthMetric:
    """Tell whether depth was measured, from the raw take (lab frame, mm).

    Where one camera's image points were put on a fixed surface, each marker's depth is a function of its place in
    the image, nearly a linear one over its small range: regressing depth on the other two coordinates, marker by
    marker, leaves next to nothing. Real heads nod and turn, and real skin leaves its tangent plane.
    """
    shape = np.nanmedian(positions, axis=0)
    axes = np.linalg.svd(shape - shape.mean(axis=0))[2]
    depth, across = axes[2], axes[:2]
    shares = []
    for marker in np.moveaxis(positions, 1, 0):
        seen = marker[np.isfinite(marker).all(axis=1)]
        if len(seen) < 20:
            continue
        z = seen @ depth
        A = np.c_[seen @ across.T, np.ones(len(seen))]
        left = z - A @ np.linalg.lstsq(A, z, rcond=None)[0]
        moved = np.linalg.norm(seen - seen.mean(axis=0), axis=1)
        shares.append(left.std() / max(np.sqrt((moved**2).mean()), 1e-9))
    share = float(np.median(shares)) if shares else 1.0
    known = share >= config.least_share
    metric = np.eye(3) if known else np.eye(3) - (1 - config.weight) * np.outer(depth, depth)
    return DepthMetric(metric, known, share)
