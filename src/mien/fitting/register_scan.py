"""One scan, no markers: the bundled topology on it (after Huang 2011, sec. 6.1, with landmarks for markers)."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float

from ..faces.bundled import BundledFace, load_face
from ..faces.scan_clean import check_scan, mended
from ..landmarks.detector import bundled_landmarks
from ..landmarks.lift import Landmarks3D, LiftConfig, lift_landmarks
from ..mesh import Attachment, Mesh, Scan, closest_point, loop_refinement, subdivided, submesh, vertex_normals
from ..one_line import one_line
from ..progress import SILENT, Progress
from ..register.correspond import Rejection, Surface
from ..register.nonrigid import Anchors, NonrigidConfig, Template
from ..rig import Rig
from ..transforms import Transform
from .model_fit import ModelFitConfig, fit_person_to_scan, landmark_anchors
from .shrink_wrap import WrapStage, shrink_wrap
from .template_parts import TemplateParts, extrapolate_hidden


@dataclass(frozen=True)
class RegisterConfig:
    """How one scan is registered. Millimetres throughout."""

    density: int = 0
    """Rounds of subdivision of the result; each has four times the triangles."""
    off_face: float = 0.15
    """Trust in closest points on outer skin beyond the face (neck, scalp, ears), against 1 on the face."""
    reliable: float = 0.6
    """A vertex is reliable where the scan is no farther away than this."""
    other_landmarks: float = 0.2
    """Weight of landmarks off lips and lids, beside 1 for those, in the stiff rounds; brows count fully in colour."""
    landmark_slack: float = 4.0
    """A landmark this far from the fitted model's counts a quarter, mm."""
    lift: LiftConfig = field(default_factory=LiftConfig)
    model: ModelFitConfig = field(default_factory=ModelFitConfig)
    first: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            markers=2.0, membrane=0.3, closest=(0.01, 0.03), coarse=(), rounds=2, rejection=Rejection(max_distance=8.0)
        )
    )
    """The stiff rounds, in which all landmarks pull."""
    second: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            markers=1.0, membrane=0.3, closest=(0.1, 0.5, 2.0), coarse=(), rejection=Rejection(max_distance=4.0)
        )
    )
    """The soft rounds, in which lips and lids alone pull."""
    fine: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            markers=0.3, closest=(0.5, 2.0), coarse=(), rejection=Rejection(max_distance=2.0)
        )
    )
    """The rounds after each subdivision."""


@dataclass(frozen=True)
class RegionError:
    """How well one region of the face is registered."""

    mean: float
    """Mean distance of its reliable vertices to the scan, mm."""
    p95: float
    """95th percentile of the same, mm."""
    covered: float
    """Share of the region that is reliable, 0..1."""


@dataclass(frozen=True)
class Registration:
    """The bundled topology on a scan."""

    mesh: Mesh
    """Face space, mm; the bundled face's topology, `RegisterConfig.density` times subdivided."""
    T_face_scan: Transform
    """Similarity: the scan's frame and unit -> face space, mm."""
    distances: Float[np.ndarray, " n"]
    """From each vertex to the scan, mm; NaN on parts that a scan does not show."""
    reliable: Bool[np.ndarray, " n"]
    """Where the scan has surface that agrees."""
    regions: dict[str, RegionError]
    landmarks: Landmarks3D
    identity: Float[np.ndarray, " i"]
    """Coefficients of the model fit, standard deviations; see `BundledFace.identity`."""
    expression: dict[str, float]
    """Weights of the model fit, ARKit names."""
    mended: tuple[str, ...] = ()
    """What was wrong with the scan and was put right, one line a fault."""

    def __repr__(self) -> str:
        return one_line(self, self.mesh, f"mean distance {np.nanmean(self.distances):.3f} mm")


def register_scan(
    scan: Scan,
    face: BundledFace | None = None,
    landmarks: Landmarks3D | None = None,
    config: RegisterConfig | None = None,
    progress: Progress = SILENT,
) -> Registration:
    """The bundled face's topology on a scan: find landmarks, fit the model, then the surface.

    Raises:
        BadInput: no surface, no face in the scan, or more than one head.
    """
    face, config = face or load_face(), config or RegisterConfig()
    check_scan(scan)
    progress.update("registering", 0, 4)
    landmarks = landmarks or lift_landmarks(scan, config.lift)
    body = TemplateParts(face)
    target, notes = mended(scan.mesh.with_vertices(landmarks.T_face_scan.apply(scan.mesh.vertices)))
    progress.update("registering", 1, 4)
    points = landmarks.T_face_scan.apply(landmarks.points)
    anchors = landmark_anchors(points, landmarks.disagreement, config=config.model)
    fitted = fit_person_to_scan(face, body, Surface(target), anchors, landmarks.scores, config.model)
    progress.update("registering", 2, 4)
    T_face_scan = fitted.T_model_target @ landmarks.T_face_scan
    surface = Surface(target.with_vertices(fitted.T_model_target.apply(target.vertices)))
    anchors = replace(anchors, points=fitted.T_model_target.apply(anchors.points))
    anchors = _believed(anchors, face.rig.neutral.with_vertices(fitted.vertices), config.landmark_slack)
    colored = scan.texture is not None or scan.mesh.colors is not None
    stages = _wrap_stages(anchors, LIPS_AND_LIDS + BROWS * colored, config)
    start = face.rig.neutral.with_vertices(fitted.vertices)
    mesh = shrink_wrap(face, body, start, surface, stages, body.trusted(config.off_face))
    progress.update("registering", 3, 4)
    mesh, trust = _refined(face, body, mesh, surface, anchors, config)
    distances, reliable = _quality(mesh, surface, trust, config)
    regions = _region_errors(face, config.density, distances, reliable)
    progress.update("registering", 4, 4)
    return Registration(
        mesh, T_face_scan, distances, reliable, regions, landmarks, fitted.identity, fitted.expression, notes
    )


def _believed(anchors: Anchors, fitted: Mesh, slack: float) -> Anchors:
    """The same with less weight where a landmark lies far from the fitted model's."""
    off = np.linalg.norm(anchors.attachment.points(fitted) - anchors.points, axis=1)
    return replace(anchors, weights=anchors.weights / (1 + (off / slack) ** 2) ** 2)


def _of_groups(anchors: Anchors, groups: tuple[str, ...]) -> Anchors:
    """The same with the landmarks of `groups` alone."""
    sets = bundled_landmarks().groups
    keep = np.zeros(len(anchors.weights), bool)
    keep[np.concatenate([sets[name] for name in groups])] = True
    return replace(anchors, weights=anchors.weights * keep)


BROWS = ("brow_left", "brow_right")
LIPS_AND_LIDS = ("lips_outer", "lips_inner", "eye_left", "eye_right")


def _wrap_stages(anchors: Anchors, sure: tuple[str, ...], config) -> list[WrapStage]:
    """Stiff (landmarks of the `sure` groups fully, the others a little), then soft (lips and lids alone)."""
    held, first = _of_groups(anchors, LIPS_AND_LIDS), _of_groups(anchors, sure)
    all_held = replace(first, weights=np.maximum(first.weights, config.other_landmarks * anchors.weights))
    return [WrapStage(config.first, all_held), WrapStage(config.second, held)]


def _refined(face, body: TemplateParts, mesh: Mesh, surface: Surface, anchors: Anchors, config):
    """Subdivide and register again, `density` times: the mesh, and the trust of its vertices."""
    trust, is_skin = body.trusted(config.off_face), np.zeros(len(mesh.vertices))
    is_skin[face.parts["skin"]] = 1.0
    held = _of_groups(anchors, LIPS_AND_LIDS)
    for _ in range(config.density):
        points = held.attachment.points(mesh)
        step = loop_refinement(mesh.faces, len(mesh.vertices))
        trust, is_skin = step.between @ trust, step.between @ is_skin
        mesh = subdivided(mesh, step)
        on_skin = np.flatnonzero((is_skin[mesh.faces] == 1).all(axis=1))
        skin, members = submesh(mesh, on_skin)
        there = closest_point(skin, points).attachment()
        on_part = replace(held, attachment=there)
        template = Template(skin, 0)
        found = template.register(surface, on_part, config.fine, trust=trust[members])
        vertices = mesh.vertices.copy()
        vertices[members] = extrapolate_hidden(template, found.vertices, trust[members] > 0)
        mesh = mesh.with_vertices(vertices)
        held = replace(held, attachment=Attachment(on_skin[there.faces], there.barycentric))
    return mesh, trust


def _quality(mesh: Mesh, surface: Surface, trust: np.ndarray, config) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the scan (NaN off the outer skin) and where they are reliable."""
    pairs = surface.correspond(mesh.vertices, vertex_normals(mesh.vertices, mesh.faces), Rejection(max_distance=5.0))
    reliable = pairs.accepted & (trust > 0.05) & (pairs.distances < config.reliable)
    return np.where(trust > 0, pairs.distances, np.nan), reliable


def _region_errors(face: BundledFace, density: int, distances, reliable) -> dict[str, RegionError]:
    """Errors by region."""
    masks, faces = dict(face.regions), face.rig.neutral.faces
    for _ in range(density):
        step = loop_refinement(faces, len(next(iter(masks.values()))))
        masks, faces = {name: step.between @ mask for name, mask in masks.items()}, step.faces
    found = {}
    for name, mask in masks.items():
        inside = mask > 0.5
        good = inside & reliable
        d = distances[good]
        mean, p95 = (float(d.mean()), float(np.quantile(d, 0.95))) if len(d) else (float("nan"), float("nan"))
        found[name] = RegionError(mean, p95, float(good.sum() / max(inside.sum(), 1)))
    return found


def registered_rig(found: Registration, face: BundledFace) -> Rig:
    """The registered face with the 52 expressions on it, fitted to its eyes; its own expression is the rest."""
    coarse = found.mesh.vertices[: len(face.rig.neutral.vertices)]
    deltas, faces = face.fitted_deltas(coarse), face.rig.neutral.faces
    while len(faces) < len(found.mesh.faces):
        step = loop_refinement(faces, deltas.shape[1])
        deltas, faces = np.stack([step.matrix @ d for d in deltas]), step.faces
    return Rig(found.mesh, deltas, face.rig.names)
