"""Laplacian deformation with one constant factorisation, and the adaptive space (Li et al. 2013, sec. 4.3-4.4).

The deformation solves K dv = G^-1 a in least squares, K = [Q; w1 I; w2 L] (eq. 7). Four things to know:

- The printed pseudoinverse K'(K K')^-1 is that of a wide matrix. K is tall, so it is (K'K)^-1 K', and K'K is factored.
- The features are taken on the plane z = 1, where P is the identity. Then Q'Q adds 1 to the three coordinates of a
  feature alike, K'K falls into three equal blocks, and one factor of a third of the size serves x, y and z. A head that
  turns changes nothing, so all is done in face space.
- As printed, eq. 4 asks for no sideways motion where the depth is right already, since its right-hand side is
  (0, 0, p_z - v_z). From H P (v + dv) on the line of sight u it is z (u - v) in the first two rows; then H^-1 of it is
  q - v with q = p_z (u_x, u_y, 1), the point at the feature's depth on its line of sight. That is what is used.
- Rows are weighed by the root of their vertex's share of the area, times the number of vertices, and L is l^2 M^-1 C
  (mass M, cotangents C) with a length l, so that the answer does not depend on how finely the mesh is cut. Noise of
  half wavelength pi l sqrt(w2 / w1) passes by half: 12 mm with the paper's w1 = 0.1, w2 = 100 and l = 0.12 mm.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32
from scipy.sparse.linalg import splu

from .._kernels import mix, track
from ..landmarks.on_rig import FEATURES
from ..mesh import cotangent_laplacian
from ..transforms import Transform
from .model import TrackingModel
from .preprocess_frame import FrameObservation
from .rigid import DepthCorrespondences

IDS = np.array(FEATURES)


@dataclass(frozen=True)
class DeformConfig:
    """The Laplacian deformation."""

    w1: float = 0.1
    """Weight of the depth points."""
    w2: float = 100.0
    """Weight of the smoothness."""
    length: float = 0.12
    """Unit of length of the Laplacian, mm: smaller follows the depth more closely."""
    features: float = 0.002
    """Weight of the features beside the depth. The paper's is 1; MediaPipe's features err by more than they mend."""
    output_features: float = 0.00003
    """Weight of the features in the output deformation, which has them alone; as weak for the same reason."""
    output_length: float = 0.35
    """Unit of length of the output's Laplacian, mm: the larger, the stiffer, the less the features pull."""
    reach: float = 12.0
    """A feature farther than this from its vertex, mm, is not believed."""


class Factored:
    """L D L' of a symmetric positive definite sparse matrix in float32, for three right-hand sides at once."""

    def __init__(self, matrix: sp.spmatrix):
        options = {"SymmetricMode": True}
        lu = splu(sp.csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        if not np.array_equal(lu.perm_r, lu.perm_c):
            raise ValueError("matrix: expected a symmetric positive definite one, got one that needs pivoting")
        below = sp.tril(lu.L, -1).tocsc()
        below.sort_indices()
        self._starts, self._indices = below.indptr.astype(np.uint64), below.indices.astype(np.uint32)
        self._values, self._inverse = below.data.astype(np.float32), (1 / lu.U.diagonal()).astype(np.float32)
        self._order = np.argsort(lu.perm_c).astype(np.uint32)

    def solve(self, right: Float[np.ndarray, "n 3"]) -> Float32[np.ndarray, "n 3"]:
        """x with matrix @ x = right."""
        return track.solve_factored(
            self._starts, self._indices, self._values, self._inverse, self._order, right.astype(np.float32)
        )


class LaplacianDeformation:
    """The two deformations of a tracking model: with depth and features (v2), with features alone (v4)."""

    def __init__(self, model: TrackingModel, config: DeformConfig = DeformConfig()):
        self.model, self.config = model, config
        self._inner = np.flatnonzero(~model.rim)
        area = (model.share * len(model.share))[self._inner, None].astype(np.float64)
        self._picks = model.picks[:, self._inner].tocsr()
        smooth = _smoothness(model)[self._inner][:, self._inner]
        seen = self._picks.T @ self._picks
        identity = sp.diags(area[:, 0])
        w1, w2 = config.w1**2, config.w2**2
        self._factor = Factored(config.features * seen + w1 * identity + w2 * config.length**4 * smooth)
        self._area = (w1 * area).astype(np.float32)
        self._touched = np.flatnonzero(np.diff(self._picks.tocsc().indptr))
        self._spread = (config.features * self._picks.T[self._touched].toarray()).astype(np.float32)
        self._response = self._feature_response(config, seen, smooth)

    def _feature_response(self, config, seen, smooth) -> Float32[np.ndarray, "f 40"]:
        """(Q'Q + w2^2 L'L)^-1 Q': with features alone the answer is a fixed matrix times the 40 offsets."""
        f = config.output_features
        matrix = sp.csc_matrix(f * seen + config.w2**2 * config.output_length**4 * smooth)
        out = np.zeros((len(self.model.front), len(FEATURES)), np.float32)
        out[self._inner] = splu(matrix).solve(f * self._picks.T.toarray())
        return out

    def with_depth(
        self, offsets: Float[np.ndarray, "f 3"], features: Float[np.ndarray, "40 3"]
    ) -> Float32[np.ndarray, "f 3"]:
        """Displacements (mm) for wanted `offsets` p - v of all vertices (0 where unseen) and q - v of the features."""
        right = self._area * offsets[self._inner]
        right[self._touched] += self._spread @ features
        moved = np.zeros(offsets.shape, np.float32)
        moved[self._inner] = self._factor.solve(right)
        return moved

    def with_features(self, features: Float[np.ndarray, "40 3"]) -> Float32[np.ndarray, "f 3"]:
        """Displacements (mm) for wanted q - v of the features alone (sec. 4.4)."""
        return self._response @ features.astype(np.float32)


def _smoothness(model: TrackingModel) -> sp.csc_matrix:
    """L'ML over the mean area of a vertex, with L = M^-1 C: 1 / mm^4; C cotangents, M areas (eq. 6)."""
    vertices = model.neutral.astype(np.float64)
    C = cotangent_laplacian(vertices, model.faces)
    corners = vertices[model.faces]
    total = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    area = np.maximum(model.share.astype(np.float64), 1e-3 / len(model.share)) * total
    return (C @ sp.diags(len(area) / (area * total)) @ C).tocsc()


def depth_offsets(match: DepthCorrespondences, T_camera_face: Transform) -> Float32[np.ndarray, "f 3"]:
    """p - v in face space, mm, 0 where nothing corresponds (eq. 3).

    p is the foot of v on the tangent plane of its depth pixel: the pixel itself would pull along the line of sight,
    which on the sides of the face is mostly sideways.
    """
    return track.plane_offsets(match.points, match.found, match.plane, match.weight, T_camera_face.rotation)


def feature_offsets(
    model: TrackingModel,
    vertices: Float[np.ndarray, "f 3"],
    observation: FrameObservation,
    T_camera_face: Transform,
    reach: float,
    use_depth: bool = True,
) -> Float[np.ndarray, "40 3"]:
    """q - v of the 40 features in face space, mm (eq. 4); 0 where a feature is missing or over `reach` away.

    q lies on the feature's line of sight: at the depth seen there if that is near the model's, else at the model's.
    """
    if observation.rays is None:
        return np.zeros((len(FEATURES), 3))
    rays = observation.rays[IDS]
    points = T_camera_face.apply(model.features(vertices))
    z = points[:, 2]
    if use_depth and observation.depth is not None:
        seen = _depth_at(observation.depth, observation, rays)
        z = np.where(np.abs(seen - z) < reach / 2, seen, z)
    wanted = np.column_stack([rays * z[:, None], z]) - points
    near = (wanted**2).sum(1) <= reach**2
    wanted[~near] = 0
    return wanted @ T_camera_face.rotation


def _depth_at(depth: np.ndarray, observation: FrameObservation, rays: np.ndarray) -> np.ndarray:
    """Depth (mm) on lines of sight; 0 where there is none."""
    fx, fy, cx, cy = observation.intrinsics
    h, w = depth.shape
    u, v = np.rint(np.nan_to_num(rays, nan=-1e6) * [fx, fy] + [cx, cy]).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < w) & (v < h)
    return np.where(inside, depth[v * inside, u * inside], 0)


@dataclass(frozen=True)
class Subspace:
    """Shapes of the front, orthonormal when every vertex counts by its share of the area."""

    shapes: Float32[np.ndarray, "a coordinates"]
    """U', displacements of the f vertices in rows of 3f; U' D U = I with D the shares."""
    duals: Float32[np.ndarray, "a coordinates"]
    """U' D: coefficients are `duals @ displacement`."""

    def coefficients(self, displacement: Float32[np.ndarray, "f 3"]) -> Float[np.ndarray, " a"]:
        """M' (v - b0); the shapes being orthonormal, their squares add up to the projection's mean square, mm^2."""
        return mix.products(self.duals, displacement.ravel())

    def project(self, displacement: Float32[np.ndarray, "f 3"]) -> Float32[np.ndarray, "f 3"]:
        """M M' (v - b0), the nearest displacement in the span, in mean square over the area."""
        coefficients = self.coefficients(displacement).astype(np.float32)
        return mix.combine(self.shapes, coefficients[:, None]).reshape(displacement.shape)


def anchor_space(model: TrackingModel, least: float = 0.01) -> Subspace:
    """M_A: the principal components of the initial blendshapes, B B' = M_A D M_A' (Li et al. 2013, sec. 5).

    Components under `least` mm in root mean square over the front (gaze, say) are left out.
    """
    root = np.repeat(np.sqrt(model.share.astype(np.float64)), 3)[:, None]
    flat = model.basis.reshape(-1, model.shapes)
    U, size, _ = np.linalg.svd(root * flat, full_matrices=False)
    return weighted_subspace(model, U[:, size > least].T)


def weighted_subspace(model: TrackingModel, orthonormal: Float[np.ndarray, "a coordinates"]) -> Subspace:
    """From plainly orthonormal rows in coordinates times the root of the share."""
    root = np.repeat(np.sqrt(np.maximum(model.share, 1e-12)), 3)
    return Subspace(
        np.ascontiguousarray(orthonormal / root, np.float32), np.ascontiguousarray(orthonormal * root, np.float32)
    )
