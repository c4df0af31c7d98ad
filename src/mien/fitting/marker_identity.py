"""Who wears the markers: identity, pose, stand-off and attachment from one calm frame, in turn until they agree."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..faces.bundled import BundledFace
from ..mesh import Attachment, Mesh
from ..transforms import Transform
from .morphable import FaceFitConfig, FaceState, fit_face, identity_model
from .terms import MarkerTerm, closest_below, surface_points


@dataclass(frozen=True)
class IdentityConfig:
    """How far a person may be from the mean face, and markers from the skin."""

    rounds: int = 12
    """Rounds of closest points and least squares."""
    noise_mm: float = 2.0
    """What the identity space cannot tell, plus jitter, mm."""
    slide_mm: tuple[float, float] = (12.0, 4.0)
    """How far a marker is free to slide along the skin, first and last round, mm: closest points are no true ones."""
    standoff_mm: float = 2.0
    """Expected distance from the skin to a marker's centre, mm: spheres and half spheres of 3 to 6 mm."""
    standoff_deviation_mm: float = 0.7
    """How far the take's common stand-off may differ from that, mm."""
    fade_mm: float = np.inf
    """A marker this far from the skin counts a quarter; inf: all are on it."""


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
    model = identity_model(face)
    begin = np.zeros(len(model.modes)) if start is None else start
    slides = np.geomspace(*config.slide_mm, config.rounds).tolist()
    term = MarkerTerm(cloud, region, attachment, None, config.noise_mm, slides, config.fade_mm)
    fitting = FaceFitConfig(config.rounds, True, config.standoff_mm, config.standoff_deviation_mm)
    state = FaceState(begin, _recentred(T_face_head, cloud).inverse(), config.standoff_mm)
    fit = fit_face(model, {"markers": term}, fitting, state)
    neutral = person(face, fit.state.coefficients)
    T, standoff = fit.state.T_target_model.inverse(), fit.state.standoff
    held = term.held(neutral, fit.state)
    residuals = np.linalg.norm(T.apply(cloud) - surface_points(neutral, held, standoff), axis=1)
    return IdentityFit(fit.state.coefficients, neutral, T, held, standoff, residuals)


def on_closest(fit: IdentityFit, cloud: Float[np.ndarray, "markers 3"], region: np.ndarray) -> IdentityFit:
    """The same person and pose with every marker at its closest point: neighbours keep their true distances."""
    points = fit.T_face_head.apply(cloud)
    held = closest_below(fit.neutral, region, points, fit.standoff_mm)
    residuals = np.linalg.norm(points - surface_points(fit.neutral, held, fit.standoff_mm), axis=1)
    return replace(fit, attachment=held, residuals=residuals)


def on_skin(fit: IdentityFit, cloud: Float[np.ndarray, "markers 3"], skin: np.ndarray, beyond_mm: float) -> IdentityFit:
    """Markers farther than `beyond_mm` from their places put on the triangles of `skin` where those are nearer.

    The face is fitted by the face; a marker under the jaw or on the temple sits beyond it.
    """
    other = on_closest(fit, cloud, skin)
    nearer = (fit.residuals > beyond_mm) & (other.residuals < fit.residuals)
    faces = np.where(nearer, other.attachment.faces, fit.attachment.faces)
    barycentric = np.where(nearer[:, None], other.attachment.barycentric, fit.attachment.barycentric)
    residuals = np.where(nearer, other.residuals, fit.residuals)
    return replace(fit, attachment=Attachment(faces, barycentric), residuals=residuals)


def person(face: BundledFace, coefficients: Float[np.ndarray, " modes"]) -> Mesh:
    """The neutral face with these identity coefficients."""
    mean = face.rig.neutral
    return mean.with_vertices(mean.vertices + np.tensordot(coefficients, face.identity.modes, axes=1))


def _recentred(T: Transform, cloud: np.ndarray) -> Transform:
    """A similarity's rotation with the translation that keeps the cloud's centre where the similarity put it."""
    centre = cloud.mean(axis=0)
    return Transform(T.rotation, T.apply(centre[None])[0] - T.rotation @ centre)
