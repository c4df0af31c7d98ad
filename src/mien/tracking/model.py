"""Everything of a rig that the tracker needs and that does not change while it runs."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Float32, Int

from ..errors import BadInput
from ..landmarks.on_rig import FEATURES, LandmarkMap, skin_faces
from ..mesh import Mesh, adjacency, boundary_vertices, connected_parts, mass, vertex_normals
from ..rig import Rig
from .packed_basis import PackedBasis, pack
from .terms.weight_prior import WeightPrior, dearer_where_idle, weight_prior

EYE_CORNERS = (33, 263)
"""Landmarks at the outer corners of the eyes, the right one first."""
LEAST_FORWARD = -0.1
"""The front's normals point at least so far forward: the sides of the nose just turn away."""
POINTS = 3480.0
"""What the depth term weighs in all, in vertices: the frontal vertices of the paper's mesh, whatever ours has."""


@dataclass(frozen=True)
class TrackingModel:
    """The front of a face: the vertices that depth is fitted to and that deform."""

    rig: Rig
    landmarks: LandmarkMap
    front: Int[np.ndarray, " f"]
    """The front's vertices in the rig."""
    faces: Int[np.ndarray, "m 3"]
    """The front's triangles, indices into `front`."""
    neutral: Float32[np.ndarray, "f 3"]
    """b0 of the front, face space, mm."""
    basis: Float32[np.ndarray, "f 3 k"]
    """B of the front."""
    packed_basis: PackedBasis
    """The same, packed."""
    share: Float32[np.ndarray, " f"]
    """Each vertex's share of the front's area; they add up to 1, so that sums mean the same for any mesh."""
    rim: Bool[np.ndarray, " f"]
    """Vertices beside the rest of the skin: displacements end there (the Dirichlet boundary)."""
    fade: Float32[np.ndarray, " f"]
    """0 on the rim, 1 from three edges inwards."""
    picks: sp.csr_matrix
    """E (40, f): the features from the front's vertices."""
    corners: tuple[Int[np.ndarray, "40 c"], Float[np.ndarray, "40 c"]]
    """The same, as vertices and weights a feature."""
    landmark_neutral: Float[np.ndarray, "478 3"]
    """All landmarks on b0, mm; an unknown one is somewhere."""
    landmark_basis: Float[np.ndarray, "478 3 k"]
    """What each shape does to them."""
    centre: Float[np.ndarray, " 3"]
    """Middle of the front, face space, mm: what the head's small turns are about."""
    size: Float[np.ndarray, " k"]
    """How far each shape moves the front, mm root mean square."""
    prior: WeightPrior
    """What the shapes' names say of their coefficients."""
    scale_mm: float
    """Distance between the outer eye corners on the neutral, mm."""

    @property
    def shapes(self) -> int:
        """k, the number of blendshapes."""
        return self.basis.shape[2]

    def blend(self, weights: Float[np.ndarray, " k"]) -> Float32[np.ndarray, "f 3"]:
        """v1 = b0 + B x on the front (Li et al. 2013, sec. 4.2)."""
        return self.packed_basis.blend(self.neutral, weights)

    def features(self, vertices: Float[np.ndarray, "f 3"]) -> Float[np.ndarray, "40 3"]:
        """Where the 40 features are when the front's vertices are `vertices`."""
        corners, weights = self.corners
        return (weights[:, :, None] * vertices[corners]).sum(1)

    def whole(self, weights: Float[np.ndarray, " k"], front: Float[np.ndarray, "f 3"]) -> Float[np.ndarray, "n 3"]:
        """The whole rig under `weights`, with the front's vertices as given, mm."""
        vertices = self.rig.vertices(weights)
        offset = front - vertices[self.front]
        vertices[self.front] += self.fade[:, None] * offset
        return vertices

    def dearer_where_idle(self, weights: Float[np.ndarray, "frames k"], in_use: float) -> "TrackingModel":
        """The model with dearer shapes where a take's weights say that it hardly uses them."""
        return replace(self, prior=dearer_where_idle(self.prior, weights, in_use))


def tracking_model(
    rig: Rig, landmarks: LandmarkMap, reach: float = 45.0, below: float = np.inf
) -> TrackingModel:
    """The front: skin that looks forward and lies within `reach` mm of a feature of the neutral.

    What lies above the height `below` (face space, mm) is left out: it is hidden.

    Raises:
        BadInput: the rig has no shapes, or a feature that is not hidden is unknown on it.
    """
    if not len(rig.names):
        raise BadInput("the rig has no shapes; make one with `mien personalize`")
    open_to_view = landmarks.attachment.points(rig.neutral)[:, 1] < below
    if not (landmarks.known | ~open_to_view)[list(FEATURES)].all():
        raise BadInput("the rig's landmarks are not complete; make it anew with `mien personalize`")
    mesh = rig.neutral
    keep = _front_faces(rig, landmarks, reach, below)
    front, local = np.unique(mesh.faces[keep], return_inverse=True)
    faces = local.reshape(-1, 3).astype(np.int32)
    area = mass(mesh.vertices[front], faces)
    rim, share = _rim(mesh, keep, front), (area / area.sum()).astype(np.float32)
    basis = np.ascontiguousarray(rig.deltas[:, front].transpose(1, 2, 0), dtype=np.float32)
    picks = landmarks.attachment.matrix(mesh)[list(FEATURES)][:, front].tocsr()
    return TrackingModel(
        rig=rig,
        landmarks=landmarks,
        front=front,
        faces=faces,
        neutral=mesh.vertices[front].astype(np.float32),
        basis=basis,
        packed_basis=pack(mesh.vertices[front], basis),
        share=share,
        rim=rim,
        fade=_fade(faces, rim),
        picks=picks,
        corners=_corners(picks),
        landmark_neutral=np.ascontiguousarray(landmarks.attachment.points(mesh)),
        landmark_basis=_landmark_basis(rig, landmarks),
        centre=mesh.vertices[front].mean(0),
        size=np.sqrt(np.einsum("f,fdk->k", share, basis.astype(np.float64) ** 2)),
        prior=weight_prior(rig.names),
        scale_mm=_eye_span(landmarks, mesh),
    )


def _front_faces(rig: Rig, landmarks: LandmarkMap, reach: float, below: float) -> np.ndarray:
    """Mask of the rig's triangles that belong to the front: with what it encloses (mouth bag, sockets, nostrils)."""
    mesh = rig.neutral
    features = landmarks.attachment.points(mesh)[list(FEATURES)]
    squared = ((mesh.vertices[:, None, :] - features) ** 2).sum(2).min(1)
    forward = vertex_normals(mesh.vertices, mesh.faces)[:, 2] > LEAST_FORWARD
    near = (squared < reach**2) & forward & (mesh.vertices[:, 1] < below)
    keep = near[mesh.faces].all(1)
    keep[landmarks.attachment.faces[list(FEATURES)][features[:, 1] < below]] = True
    skin = skin_faces(mesh)
    outside = np.flatnonzero(skin & ~keep)
    if not len(outside):
        return skin
    part = connected_parts(mesh.faces[outside], len(mesh.vertices))[mesh.faces[outside, 0]]
    skin[outside[part == np.bincount(part).argmax()]] = False
    return skin


def _rim(mesh: Mesh, keep: np.ndarray, front: np.ndarray) -> np.ndarray:
    """Front vertices that the rest of the skin touches; a face that is all front has the mesh's border for a rim."""
    rest = skin_faces(mesh) & ~keep
    return np.isin(front, np.unique(mesh.faces[rest]) if rest.any() else boundary_vertices(mesh.faces[keep]))


def _fade(faces: np.ndarray, rim: np.ndarray, rings: int = 3) -> np.ndarray:
    near = adjacency(faces, len(rim)) + sp.identity(len(rim))
    reached, fade = rim.astype(float), 1.0 - rim
    for ring in range(1, rings):
        reached = np.minimum(near @ reached, 1.0)
        fade = np.where((reached > 0) & (fade == 1), ring / rings, fade)
    return fade.astype(np.float32)


def _landmark_basis(rig: Rig, landmarks: LandmarkMap) -> np.ndarray:
    corners = rig.neutral.faces[landmarks.attachment.faces]
    basis = np.einsum("kpcd,pc->pdk", rig.deltas[:, corners], landmarks.attachment.barycentric)
    return np.ascontiguousarray(basis)


def _corners(picks: sp.csr_matrix) -> tuple[np.ndarray, np.ndarray]:
    """Columns and values of a sparse matrix's rows, side by side, short rows filled with weights of 0."""
    rows = np.diff(picks.indptr)
    vertices, weights = np.zeros((len(rows), rows.max()), np.int64), np.zeros((len(rows), rows.max()))
    there = np.arange(rows.max()) < rows[:, None]
    vertices[there], weights[there] = picks.indices, picks.data
    return vertices, weights


def _eye_span(landmarks: LandmarkMap, mesh) -> float:
    right, left = landmarks.attachment.points(mesh)[list(EYE_CORNERS)]
    return float(np.linalg.norm(left - right))
