"""What a face model is fitted to: surface, 3D landmarks, lines of sight, markers. One short term each.

Every term gives weighted residuals (goal less model) and their Jacobian for `morphable.fit_face`. Far-off measurements
fade: weights fall as 1 / (1 + (r / scale)^2)^2, Geman and McClure's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from ..mesh import Attachment, ClosestPoint, Mesh, mass, submesh, vertex_normals
from ..register.correspond import Rejection, Surface
from ..register.sides import same_side
from .morphable import FaceState, ModelPoints, MorphableModel, Rows, points_at, vertices_at

FADE = 2.5
"""A landmark off by so many times its sigma counts a quarter."""
SURFACE_FADE = 3.0
"""... and a closest point."""


def fading(distances: Float[np.ndarray, " r"], scale: float) -> Float[np.ndarray, " r"]:
    """Geman and McClure's weights: 1 at 0, a quarter at `scale`; an infinite scale switches them off."""
    return 1 / (1 + (distances / scale) ** 2) ** 2


def scheduled(values: Sequence[float], round: int) -> float:
    """The value of a round; the last one holds on."""
    return float(values[min(round, len(values) - 1)])


@dataclass(frozen=True)
class SurfaceTerm:
    """Distances across a surface that was scanned (point to plane, Chen and Medioni 1992)."""

    points: ModelPoints
    which: Int[np.ndarray, " v"]
    """The vertices that the scan may show."""
    share: Float[np.ndarray, " v"]
    """How much each counts; they add up to the number of independent measurements that the surface is worth."""
    surface: Surface
    """In the target's frame, mm."""
    sigma: Sequence[float] = (8.0, 4.0, 2.0, 1.2, 0.8)
    """How far the surface is expected to be from the model, mm, round by round: it begins to count late."""
    rejection: Rejection = field(default_factory=lambda: Rejection(max_distance=15.0, max_angle_deg=50.0))
    """Which closest points count."""
    fade: float = SURFACE_FADE
    sides: Int[np.ndarray, " v"] | None = None
    """Which of two lips or lids each vertex is of; the two never match each other (see `register.sides`)."""

    def rows(self, model: MorphableModel, state: FaceState, round: int) -> Rows:
        """Closest points of all vertices that may be shown, each along the scan's normal."""
        sigma = scheduled(self.sigma, round)
        placed = self.points.placed(state)
        whole = state.T_target_model.apply(model.vertices(state.coefficients))
        pairs = self.surface.correspond(placed, vertex_normals(whole, model.faces)[self.which], self.rejection)
        accepted = pairs.accepted
        if self.sides is not None:
            accepted = accepted & same_side(placed, self.sides, pairs.points)
        weights = self.share * accepted * fading(pairs.distances, self.fade * sigma)
        root, n = np.sqrt(weights) / sigma, pairs.normals
        turn = np.cross(placed - state.T_target_model.translation, n)
        shapes = np.einsum("vb,vbk->vk", n @ state.T_target_model.rotation, self.points.modes)
        jacobian = np.concatenate([turn, n, shapes, np.zeros((len(n), 1))], axis=1)
        across = np.einsum("vd,vd->v", pairs.points - placed, n)
        return Rows(root * across, root[:, None] * jacobian)


def surface_term(
    model: MorphableModel,
    surface: Surface,
    trust: Float[np.ndarray, " n"],
    samples: float = 400.0,
    sides: Int[np.ndarray, " n"] | None = None,
    **how,
) -> SurfaceTerm:
    """A surface term over the vertices with `trust` > 0, weighed by their area and trust.

    Args:
        samples: the surface counts as so many independent measurements, since neighbouring vertices err alike.
        sides: of all vertices.
        how: further fields of `SurfaceTerm`.
    """
    which = np.flatnonzero(trust > 0)
    area = mass(model.mean, model.faces)[which] * trust[which]
    share = samples * area / area.sum()
    of_which = None if sides is None else sides[which]
    return SurfaceTerm(vertices_at(model, which), which, share, surface, sides=of_which, **how)


@dataclass(frozen=True)
class LandmarkTerm:
    """Points of the face whose places are known in 3D."""

    points: ModelPoints
    goals: Float[np.ndarray, "p 3"]
    """Target's frame, mm."""
    weights: Float[np.ndarray, " p"]
    """0 leaves one out."""
    sigma: float = 2.0
    """How wrong a landmark is expected to be, mm."""
    fade: float = FADE

    def rows(self, model: MorphableModel, state: FaceState, round: int) -> Rows:
        """Three rows a landmark."""
        placed = self.points.placed(state)
        missing = self.goals - placed
        weights = self.weights * fading(np.linalg.norm(missing, axis=1), self.fade * self.sigma)
        root = np.repeat(np.sqrt(weights) / self.sigma, 3)
        jacobian = self.points.jacobian(state, placed).reshape(len(root), -1)
        return Rows(root * missing.ravel(), root[:, None] * jacobian)


def landmark_term(
    model: MorphableModel,
    attachment: Attachment,
    goals: Float[np.ndarray, "p 3"],
    weights: Float[np.ndarray, " p"],
    **how,
) -> LandmarkTerm:
    """A landmark term of points attached to the model; those without a weight are left out."""
    used = np.flatnonzero(weights > 0)
    few = Attachment(attachment.faces[used], attachment.barycentric[used])
    return LandmarkTerm(points_at(model, few), goals[used], weights[used], **how)


@dataclass(frozen=True)
class RayTerm:
    """2D landmarks as lines of sight: what counts is how far the point is off its line, not where along it."""

    points: ModelPoints
    origins: Float[np.ndarray, "p 3"]
    """Where each was seen from, target's frame, mm."""
    directions: Float[np.ndarray, "p 3"]
    """Of any length."""
    weights: Float[np.ndarray, " p"]
    sigma: float = 2.0
    """How far a landmark may lie off its line of sight, mm."""
    fade: float = FADE

    def rows(self, model: MorphableModel, state: FaceState, round: int) -> Rows:
        """Three rows a landmark, the offset sideways to the line."""
        placed = self.points.placed(state)
        d = self.directions / np.linalg.norm(self.directions, axis=1, keepdims=True)
        sideways = np.eye(3) - d[:, :, None] * d[:, None, :]
        missing = np.einsum("pab,pb->pa", sideways, self.origins - placed)
        weights = self.weights * fading(np.linalg.norm(missing, axis=1), self.fade * self.sigma)
        root = np.sqrt(weights) / self.sigma
        jacobian = np.einsum("p,pab,pbu->pau", root, sideways, self.points.jacobian(state, placed))
        return Rows((root[:, None] * missing).ravel(), jacobian.reshape(3 * len(d), -1))


def ray_term(
    model: MorphableModel,
    attachment: Attachment,
    origins: Float[np.ndarray, "p 3"],
    directions: Float[np.ndarray, "p 3"],
    weights: Float[np.ndarray, " p"],
    **how,
) -> RayTerm:
    """A ray term of points attached to the model; those without a weight are left out."""
    used = np.flatnonzero(weights > 0)
    few = Attachment(attachment.faces[used], attachment.barycentric[used])
    return RayTerm(points_at(model, few), origins[used], directions[used], weights[used], **how)


@dataclass(frozen=True)
class MarkerTerm:
    """Markers glued on the skin, their centres one stand-off above it.

    With `attachment` None they take their closest points on the triangles of `region`, and slide along the skin.
    """

    cloud: Float[np.ndarray, "p 3"]
    """Target's frame, mm."""
    region: Int[np.ndarray, " f"]
    """Triangles on which markers may sit."""
    attachment: Attachment | None = None
    weights: Float[np.ndarray, " p"] | None = None
    noise_mm: float = 2.0
    """What the identity space cannot tell, plus jitter, mm."""
    slide_mm: Sequence[float] = (12.0, 4.0)
    """How far a marker is free to slide along the skin, mm, round by round: closest points are no true ones."""
    fade_mm: float = np.inf
    """A marker so far from its place counts a quarter; inf: all count alike."""

    def rows(self, model: MorphableModel, state: FaceState, round: int) -> Rows:
        """Three rows a marker: leaving the skin is dear, sliding along it cheap."""
        mesh = model.mesh(state.coefficients)
        held = self.held(mesh, state)
        points, normals = points_at(model, held), attached_normals(mesh, held)
        n = state.T_target_model.rotate(normals)
        placed = points.placed(state) + state.standoff * n
        jacobian = points.jacobian(state, placed)
        jacobian[:, :, -1] = n
        along = n[:, :, None] * n[:, None, :]
        loose = np.hypot(self.noise_mm, scheduled(self.slide_mm, round))
        root = along / self.noise_mm + (np.eye(3) - along) / loose
        missing = self.cloud - placed
        weights = fading(np.linalg.norm(missing, axis=1), self.fade_mm)
        if self.weights is not None:
            weights = weights * self.weights
        root = np.sqrt(weights)[:, None, None] * root
        residual = np.einsum("pab,pb->pa", root, missing)
        return Rows(residual.ravel(), np.einsum("pab,pbu->pau", root, jacobian).reshape(3 * len(n), -1))

    def held(self, mesh: Mesh, state: FaceState) -> Attachment:
        """Where the markers sit on `mesh` (model frame)."""
        if self.attachment is not None:
            return self.attachment
        cloud = state.T_target_model.inverse().apply(self.cloud)
        return closest_below(mesh, self.region, cloud, state.standoff)


def attached_normals(mesh: Mesh, attachment: Attachment) -> Float[np.ndarray, "p 3"]:
    """Unit normals of a mesh at attached points."""
    corners = vertex_normals(mesh.vertices, mesh.faces)[mesh.faces[attachment.faces]]
    normals = np.einsum("pc,pcd->pd", attachment.barycentric, corners)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def surface_points(mesh: Mesh, attachment: Attachment, standoff: float | np.ndarray) -> Float[np.ndarray, "p 3"]:
    """Attached points lifted off the skin along the normal, mm."""
    return attachment.points(mesh) + np.asarray(standoff)[..., None] * attached_normals(mesh, attachment)


def closest_below(
    mesh: Mesh, region: Int[np.ndarray, " f"], cloud: Float[np.ndarray, "p 3"], standoff: float
) -> Attachment:
    """Closest points on the triangles of `region`, seen from the surface `standoff` mm above on which markers lie."""
    lifted = mesh.vertices + standoff * vertex_normals(mesh.vertices, mesh.faces)
    part, _ = submesh(mesh.with_vertices(lifted), region)
    found = ClosestPoint(part).query(cloud).attachment()
    return Attachment(region[found.faces], found.barycentric)
