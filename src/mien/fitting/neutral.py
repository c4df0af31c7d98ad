"""The neutral face from a merged scan (Li et al. 2013, sec. 3): identity coefficients, then a shrink-wrap."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ..faces.bundled import BundledFace
from ..landmarks.on_rig import IRISES, LandmarkMap
from ..mesh import Mesh, vertex_normals
from ..register.correspond import Rejection, Surface
from ..register.nonrigid import NonrigidConfig
from ..transforms import Transform
from .morphable import FaceFit, FaceFitConfig, MorphableModel, fit_face, identity_model
from .shrink_wrap import WrapStage, shrink_wrap
from .template_parts import TemplateParts
from .terms import ray_term, surface_term


def _closest_weights(*half_waves: float) -> tuple[float, ...]:
    """Weights of closest points (eq. 7's w3) at which detail finer than each half wavelength, mm, is not followed."""
    return tuple(float((np.pi / wave) ** 4) for wave in half_waves)


@dataclass(frozen=True)
class NeutralFitConfig:
    """The identity fit and the shrink-wrap."""

    fit: FaceFitConfig = field(default_factory=FaceFitConfig)
    identity_deviation: float = 1.0
    """Standard deviation of the identity's coefficients: 1 is the people that the space was made from."""
    surface_sigma: tuple[float, ...] = (8.0, 8.0, 8.0, 4.0, 4.0, 4.0, 2.0, 2.0, 2.0, 1.2, 1.2, 1.2, 0.8)
    """How far the scan is expected to be from the model, mm, round by round."""
    samples: float = 1000.0
    """The scan counts as so many independent measurements."""
    sight_sigma: float = 3.0
    """How far a landmark is expected to be off its line of sight, mm."""
    sight_samples: float = 40.0
    """All landmarks together count as so many independent ones: they err in groups."""
    wrap: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            closest=_closest_weights(40.0, 20.0, 10.0, 6.0), coarse=(), membrane=0.0, rejection=Rejection(5.0)
        )
    )
    """Shrink-wrap: half wavelengths below which detail of the scan is not followed: 40, 20, 10, 6 mm."""
    reach: Rejection = field(default_factory=lambda: Rejection(max_distance=20.0))
    """Which closest points count in the identity fit."""


@dataclass(frozen=True)
class NeutralResult:
    """A person's neutral face in the bundled topology."""

    mesh: Mesh
    """Face space, mm."""
    coefficients: Float[np.ndarray, " c"]
    """Identity coefficients, standard deviations."""
    T_scan_face: Transform
    fitted: float
    """Mean distance from the scan after the identity fit, mm."""
    wrapped: float
    """Mean distance from the scan after the shrink-wrap, mm."""


def fit_neutral(
    face: BundledFace,
    landmarks: LandmarkMap,
    scan: Mesh,
    seen: Float[np.ndarray, "478 3"],
    eye: Float[np.ndarray, " 3"],
    config: NeutralFitConfig = NeutralFitConfig(),
) -> NeutralResult:
    """Fit the identity space with a rigid transform, then follow the scan's detail.

    Args:
        landmarks: where MediaPipe's landmarks are on the bundled face.
        scan: mm, roughly in face space.
        seen: the landmarks found on the scan, in its space; NaN where unknown.
        eye: where the camera was, in the scan's space; landmarks are known sideways to its line of sight alone.
    """
    parts = TemplateParts(face)
    trust = parts.trusted(off_face=0.0)
    model = identity_model(face, config.identity_deviation)
    fit = fit_identity_to_scan(model, landmarks, Surface(scan), seen, eye, trust, config)
    home = fit.state.T_target_model.inverse()
    in_face = Surface(scan.with_vertices(home.apply(scan.vertices)))
    mesh = face.rig.neutral.with_vertices(fit.vertices)
    wrapped = shrink_wrap(face, parts, mesh, in_face, [WrapStage(config.wrap)], trust)
    distances = [_mean_distance(m, in_face, trust, config.wrap.rejection) for m in (mesh, wrapped)]
    return NeutralResult(wrapped, fit.state.coefficients, fit.state.T_target_model, *distances)


def fit_identity_to_scan(
    model: MorphableModel,
    landmarks: LandmarkMap,
    surface: Surface,
    seen: Float[np.ndarray, "478 3"],
    eye: Float[np.ndarray, " 3"],
    trust: Float[np.ndarray, " n"],
    config: NeutralFitConfig = NeutralFitConfig(),
) -> FaceFit:
    """Pose and identity from the scan's surface and the lines of sight from `eye` through the landmarks `seen`."""
    used = landmarks.known & np.isfinite(seen[:, 0]) & (np.arange(len(seen)) < IRISES.start)
    weights = used * min(1.0, config.sight_samples / max(used.sum(), 1))
    origins = np.broadcast_to(eye, seen.shape)
    on_face, ways = landmarks.attachment, np.nan_to_num(seen) - eye
    surface_rows = surface_term(
        model, surface, trust, config.samples, sigma=config.surface_sigma, rejection=config.reach
    )
    terms = {
        "surface": surface_rows,
        "sight": ray_term(model, on_face, origins, ways, weights, sigma=config.sight_sigma),
    }
    return fit_face(model, terms, config.fit)


def _mean_distance(mesh: Mesh, surface: Surface, trust: Float[np.ndarray, " n"], rejection: Rejection) -> float:
    """Mean distance from the scan of the vertices that it shows, mm."""
    pairs = surface.correspond(mesh.vertices, vertex_normals(mesh.vertices, mesh.faces), rejection)
    return float(pairs.distances[pairs.accepted & (trust > 0)].mean())
