"""d1 and d2 over the surface: the parameters of a displacement map at any points, frame by frame (eq. 3)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, Int32

from .._kernels import polymap
from ..mesh import Attachment, Mesh
from .domain import Domain
from .marker_mesh import interpolation


@dataclass(frozen=True)
class ParameterField:
    """Points on the base, the markers round each, and the bases there: S, Q and R interpolated barycentrically."""

    corners: Int32[np.ndarray, "p 3"]
    weights: Float32[np.ndarray, "p 3"]
    bases: Float32[np.ndarray, "p 5 2"]

    def parameters(self, vectors: Float[np.ndarray, "k 5"]) -> Float32[np.ndarray, "p 2"]:
        """d1 and d2 at the points, mm, under one frame's deformation vectors."""
        out = np.empty((len(self.corners), 2), np.float32)
        polymap.parameter_fields(vectors.astype(np.float32), self.corners, self.weights, self.bases, out)
        return out


def parameter_field(domain: Domain, mesh: Mesh, attachment: Attachment, points: Attachment) -> ParameterField:
    """The field at `points` of the base `mesh`; `attachment` places the markers on it."""
    found = interpolation(domain.coarse, mesh, attachment, points)
    bases = found.of(domain.bases)
    return ParameterField(found.corners.astype(np.int32), found.weights.astype(np.float32), bases.astype(np.float32))
