"""Who wears the markers: identity, pose, stand-off and attachment from one calm frame, in turn until they agree."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..faces.bundled import BundledFace
from ..mesh import Attachment, ClosestPoint, Mesh, submesh, vertex_normals
from ..transforms import Transform, rotation_from_vector, skew


@dataclass(frozen=True)
class IdentityConfig:
    """How far a person may be from the mean face, and markers from the skin."""

    rounds: int = 12
    """Rounds of closest points and least squares."""
    noise_mm: float = 2.0
    """What the identity space cannot tell, plus jitter, mm."""
    slide_mm: tuple[float, float] = (12.0, 4.0)
    """How far a marker is free to slide along the skin, first and last round, mm: closest points are no true ones."""
    standoff_mm: float = 3.0
    """Expected distance from the skin to a marker's centre, mm."""
    standoff_deviation_mm: float = 1.0
    """How far the take's common stand-off may differ from that, mm."""


@dataclass(frozen=True)
class IdentityFit:
    """A person's neutral face under the markers."""

    coefficients: Float[np.ndarray, " modes"]
    """Of the identity space, standard deviations."""
    neutral: Mesh
    """The person, face space, mm."""
    T_face_head: Transform
    """Rigid: the take's head frame -> face space."""
    attachment: Attachment
    """Where the markers sit."""
    standoff_mm: float
    """Common distance of the markers' centres from the skin."""
    residuals: Float[np.ndarray, " markers"]
    """Distance from marker to model, mm."""


def fit_identity(
    cloud: Float[np.ndarray, "markers 3"],
    face: BundledFace,
    region: np.ndarray,
    T_face_head: Transform,
    attachment: Attachment | None = None,
    start: Float[np.ndarray, " modes"] | None = None,
    config: IdentityConfig = IdentityConfig(),
) -> IdentityFit:
    """Identity coefficients, rigid pose and one stand-off for markers `cloud` (head frame, mm).

    With `attachment` None the markers take their closest points on the triangles of `region`, and are free to slide;
    with one given they are held to it.
    """
    modes = face.identity.modes
    coefficients = np.zeros(len(modes)) if start is None else start
    T = _recentred(T_face_head, cloud)
    standoff = config.standoff_mm
    given = attachment
    slides = np.geomspace(*config.slide_mm, config.rounds)
    for slide in slides:
        neutral = person(face, coefficients)
        held = given if given is not None else _closest(neutral, region, T.apply(cloud), standoff)
        step = _least_squares(neutral, face, held, T.apply(cloud), coefficients, standoff, slide, config)
        coefficients, standoff, increment = step
        T = increment @ T
    neutral = person(face, coefficients)
    held = given if given is not None else _closest(neutral, region, T.apply(cloud), standoff)
    residuals = np.linalg.norm(T.apply(cloud) - surface_points(neutral, held, standoff), axis=1)
    return IdentityFit(coefficients, neutral, T, held, float(standoff), residuals)


def on_closest(fit: IdentityFit, cloud: Float[np.ndarray, "markers 3"], region: np.ndarray) -> IdentityFit:
    """The same person and pose with every marker at its closest point: neighbours keep their true distances."""
    points = fit.T_face_head.apply(cloud)
    held = _closest(fit.neutral, region, points, fit.standoff_mm)
    residuals = np.linalg.norm(points - surface_points(fit.neutral, held, fit.standoff_mm), axis=1)
    return replace(fit, attachment=held, residuals=residuals)


def person(face: BundledFace, coefficients: Float[np.ndarray, " modes"]) -> Mesh:
    """The neutral face with these identity coefficients."""
    mean = face.rig.neutral
    return mean.with_vertices(mean.vertices + np.tensordot(coefficients, face.identity.modes, axes=1))


def surface_points(mesh: Mesh, attachment: Attachment, standoff: float | np.ndarray) -> Float[np.ndarray, "p 3"]:
    """Attached points lifted off the skin along the normal, mm."""
    return attachment.points(mesh) + np.asarray(standoff)[..., None] * _normals(mesh, attachment)


def _recentred(T: Transform, cloud: np.ndarray) -> Transform:
    """A similarity's rotation with the translation that keeps the cloud's centre where the similarity put it."""
    centre = cloud.mean(axis=0)
    return Transform(T.rotation, T.apply(centre[None])[0] - T.rotation @ centre)


def _normals(mesh: Mesh, attachment: Attachment) -> np.ndarray:
    normals = vertex_normals(mesh.vertices, mesh.faces)[mesh.faces[attachment.faces]]
    normals = np.einsum("pc,pcd->pd", attachment.barycentric, normals)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _closest(neutral: Mesh, region: np.ndarray, points: np.ndarray, standoff: float) -> Attachment:
    """Closest points on the region, seen from the surface that the marker centres lie on."""
    lifted = neutral.vertices + standoff * vertex_normals(neutral.vertices, neutral.faces)
    part, _ = submesh(neutral.with_vertices(lifted), region)
    found = ClosestPoint(part).query(points).attachment()
    return Attachment(region[found.faces], found.barycentric)


def _least_squares(neutral, face, held, points, coefficients, standoff, slide, config):
    """One linear solve for identity, stand-off and pose increment; sliding along the skin is cheap, leaving it dear."""
    normals = _normals(neutral, held)
    corners = face.identity.modes[:, neutral.faces[held.faces]]
    modes = np.einsum("pk,cpkd->pdc", held.barycentric, corners)
    model = surface_points(neutral, held, standoff)
    shift = np.broadcast_to(np.eye(3), (len(model), 3, 3))
    columns = np.concatenate([modes, normals[..., None], skew(model), -shift], axis=2)
    along = normals[:, :, None] * normals[:, None, :]
    variance_out = config.noise_mm**2
    metric = along / variance_out + (np.eye(3) - along) / (variance_out + slide**2)
    weighted = np.einsum("pab,pbc->pac", metric, columns)
    gram = np.einsum("pac,pad->cd", columns, weighted)
    right = np.einsum("pac,pa->c", weighted, points - model)
    c = len(coefficients)
    gram[:c, :c] += np.eye(c)
    right[:c] -= coefficients
    gram[c, c] += 1 / config.standoff_deviation_mm**2
    right[c] += (config.standoff_mm - standoff) / config.standoff_deviation_mm**2
    x = np.linalg.solve(gram + 1e-9 * np.eye(len(gram)), right)
    increment = Transform(rotation_from_vector(x[c + 1 : c + 4]), x[c + 4 :])
    return coefficients + x[:c], standoff + x[c], increment
