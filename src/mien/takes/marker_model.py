"""Where a rig puts the markers: a linear model, small enough for every frame at once."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..mesh import Attachment, submesh, vertex_normals
from ..rig import Rig
from ..transforms import skew


@dataclass(frozen=True)
class MarkerModel:
    """Marker positions as a linear function of the weights: rest + sum_k w_k shapes_k, in face space, mm."""

    neutral: Float[np.ndarray, "markers 3"]
    """On the neutral face."""
    shapes: Float[np.ndarray, "shapes markers 3"]
    """How far each shape moves each marker at weight 1: D (b_k - b_0) of Huang 2011, eq. 12."""

    def points(self, weights: Float[np.ndarray, "*batch shapes"]) -> Float[np.ndarray, "*batch markers 3"]:
        """Marker positions under `weights`."""
        k, m, _ = self.shapes.shape
        return self.neutral + (weights @ self.shapes.reshape(k, m * 3)).reshape(*weights.shape[:-1], m, 3)

    def jacobian(self) -> Float[np.ndarray, "markers 3 columns"]:
        """d point / d (weights, rotation vector, translation) at rest: shapes + 6 columns."""
        shapes = np.moveaxis(self.shapes, 0, 2)
        turn = -skew(self.neutral)
        shift = np.broadcast_to(np.eye(3), turn.shape)
        return np.concatenate([shapes, turn, shift], axis=2)


def normals_at(
    D: sp.csr_matrix, vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]
) -> Float[np.ndarray, "markers 3"]:
    """Unit normals of the surface at attached points; D (markers, n) as `Attachment.matrix` gives it."""
    normals = D @ vertex_normals(vertices, faces)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def marker_model(rig: Rig, attachment: Attachment, standoff: Float[np.ndarray, " markers"]) -> MarkerModel:
    """The markers of `attachment` on `rig`, each `standoff` mm above the skin along the normal.

    The stand-off turns with the normal of each shape, to first order in the weights.
    """
    around = np.asarray(np.isin(rig.neutral.faces, rig.neutral.faces[attachment.faces]).any(axis=1))
    part, old = submesh(rig.neutral, around)
    here = np.cumsum(around) - 1
    D = Attachment(here[attachment.faces], attachment.barycentric).matrix(part)
    faces = part.faces

    def above(vertices: np.ndarray) -> np.ndarray:
        return D @ vertices + standoff[:, None] * normals_at(D, vertices, faces)

    rest = above(part.vertices)
    shapes = np.stack([above(part.vertices + delta[old]) - rest for delta in rig.deltas])
    return MarkerModel(rest, shapes)
