"""One scan, no markers: the bundled topology on it (after Huang 2011, sec. 6.1, with landmarks for markers)."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float

from ..faces.bundled import BundledFace, load_face
from ..faces.scan_clean import check_scan, mended
from ..landmarks.brow_edges import BrowConfig, brow_edges
from ..landmarks.lift import Landmarks3D, LiftConfig, lift_landmarks
from ..mesh import Attachment, Mesh, Scan, closest_point, loop_refinement, subdivided, submesh, vertex_normals
from ..one_line import one_line
from ..progress import SILENT, Progress
from ..register.correspond import Rejection, Surface
from ..register.nonrigid import Anchors, NonrigidConfig, Template
from ..rig import Rig
from ..transforms import Transform
from .model_fit import ModelFitConfig, fit_person_to_scan, landmark_anchors
from .scan_landmarks import LIPS_AND_LIDS, believed, of_groups, on_brow_edges
from .shrink_wrap import WrapStage, shrink_wrap
from .skin_pieces import skin_pieces
from .template_parts import TemplateParts, extrapolate_hidden

JUDGED = Rejection(max_distance=5.0)
"""Closest points that say how good a registration is."""
LEAST_TRUST = 0.05
"""Vertices that are trusted less are not reliable, however near the scan is."""
INSIDE = 0.5
"""From which value of its mask on a vertex belongs to a region."""


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
    """Weight of landmarks off lips and lids, beside 1 for those, in the stiff rounds."""
    brow_edge: float = 0.3
    """Weight of the brows' upper edges, where the scan's colours show them; 0 leaves brows to the landmarks.
    At 1 they err less on a real scan, more on the stage, where paint is not where the landmarks are."""
    landmark_slack: float = 4.0
    """A landmark this far from the fitted model's counts a quarter, mm."""
    lift: LiftConfig = field(default_factory=LiftConfig)
    brows: BrowConfig = field(default_factory=BrowConfig)
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
    placed = landmarks.T_face_scan.apply(scan.mesh.vertices)
    target, notes = mended(scan.mesh.with_vertices(placed))
    progress.update("registering", 1, 4)
    points = landmarks.T_face_scan.apply(landmarks.points)
    anchors = landmark_anchors(points, landmarks.disagreement, config=config.model)
    fitted = fit_person_to_scan(face, body, Surface(target), anchors, landmarks.scores, config.model)
    progress.update("registering", 2, 4)
    T_face_scan = fitted.T_model_target @ landmarks.T_face_scan
    start = face.rig.neutral.with_vertices(fitted.vertices)
    surface = Surface(skin_pieces(_placed(target, fitted.T_model_target), start, body.in_the_open))
    moved = fitted.T_model_target.apply(anchors.points)
    placed_anchors = replace(anchors, points=moved)
    anchors = believed(placed_anchors, start, config.landmark_slack)
    painted = _placed(scan.mesh, T_face_scan)
    seen = T_face_scan.apply(landmarks.points)
    edges = brow_edges(painted, scan.texture, seen, config.brows)
    anchors, brows = on_brow_edges(anchors, start, edges, config.brow_edge)
    stages = _wrap_stages(anchors, LIPS_AND_LIDS + brows, config)
    trust = body.trusted(config.off_face)
    mesh = shrink_wrap(face, body, start, surface, stages, trust)
    progress.update("registering", 3, 4)
    mesh, trust = _refined(face, body, mesh, surface, anchors, config)
    distances, reliable = _quality(mesh, surface, trust, config)
    regions = _region_errors(face, config.density, distances, reliable)
    progress.update("registering", 4, 4)
    return Registration(
        mesh=mesh,
        T_face_scan=T_face_scan,
        distances=distances,
        reliable=reliable,
        regions=regions,
        landmarks=landmarks,
        identity=fitted.identity,
        expression=fitted.expression,
        mended=notes,
    )


def _placed(mesh: Mesh, T: Transform) -> Mesh:
    return mesh.with_vertices(T.apply(mesh.vertices))


def _wrap_stages(anchors: Anchors, sure: tuple[str, ...], config: RegisterConfig) -> list[WrapStage]:
    """Stiff (landmarks of the `sure` groups fully, the others a little), then soft (the sure ones alone)."""
    held = of_groups(anchors, sure)
    little = config.other_landmarks * anchors.weights
    stiff = replace(held, weights=np.maximum(held.weights, little))
    return [
        WrapStage(config.first, stiff),
        WrapStage(config.second, held),
    ]


def _refined(face, body: TemplateParts, mesh: Mesh, surface: Surface, anchors: Anchors, config):
    """Subdivide and register again, `density` times: the mesh, and the trust of its vertices."""
    trust = body.trusted(config.off_face)
    is_skin = face.on_skin.astype(float)
    held = of_groups(anchors, LIPS_AND_LIDS)
    for _ in range(config.density):
        points = held.attachment.points(mesh)
        step = loop_refinement(mesh.faces, len(mesh.vertices))
        trust = step.between @ trust
        is_skin = step.between @ is_skin
        mesh = subdivided(mesh, step)
        corners = is_skin[mesh.faces]
        on_skin = np.flatnonzero((corners == 1).all(axis=1))
        skin, members = submesh(mesh, on_skin)
        there = closest_point(skin, points).attachment()
        on_part = replace(held, attachment=there)
        template = Template(skin, 0)
        found = template.register(surface, on_part, config.fine, trust=trust[members])
        shown = trust[members] > 0
        vertices = mesh.vertices.copy()
        vertices[members] = extrapolate_hidden(template, found.vertices, shown)
        mesh = mesh.with_vertices(vertices)
        triangles = on_skin[there.faces]
        on_mesh = Attachment(triangles, there.barycentric)
        held = replace(held, attachment=on_mesh)
    return mesh, trust


def _quality(mesh: Mesh, surface: Surface, trust: np.ndarray, config) -> tuple[np.ndarray, np.ndarray]:
    """Distances to the scan (NaN off the outer skin) and where they are reliable."""
    normals = vertex_normals(mesh.vertices, mesh.faces)
    pairs = surface.correspond(mesh.vertices, normals, JUDGED)
    near = pairs.distances < config.reliable
    reliable = pairs.accepted & near & (trust > LEAST_TRUST)
    distances = np.where(trust > 0, pairs.distances, np.nan)
    return distances, reliable


def _region_errors(face: BundledFace, density: int, distances, reliable) -> dict[str, RegionError]:
    """Errors by region."""
    faces, names = face.rig.neutral.faces, list(face.regions)
    masks = np.stack(list(face.regions.values()), axis=1)
    for _ in range(density):
        step = loop_refinement(faces, len(masks))
        masks = step.between @ masks
        faces = step.faces
    inside = masks > INSIDE
    return {name: _region_error(inside[:, i], distances, reliable) for i, name in enumerate(names)}


def _region_error(inside: Bool[np.ndarray, " n"], distances: np.ndarray, reliable: np.ndarray) -> RegionError:
    """Of one region."""
    good = inside & reliable
    covered = good.sum() / max(inside.sum(), 1)
    if not good.any():
        return RegionError(mean=float("nan"), p95=float("nan"), covered=0.0)
    there = distances[good]
    return RegionError(
        mean=float(there.mean()),
        p95=float(np.quantile(there, 0.95)),
        covered=float(covered),
    )


def registered_rig(found: Registration, face: BundledFace) -> Rig:
    """The registered face with the 52 expressions on it, fitted to its eyes; its own expression is the rest."""
    faces = face.rig.neutral.faces
    coarse = len(face.rig.neutral.vertices)
    deltas = face.fitted_deltas(found.mesh.vertices[:coarse])
    while len(faces) < len(found.mesh.faces):
        step = loop_refinement(faces, deltas.shape[1])
        deltas = np.stack([step.matrix @ delta for delta in deltas])
        faces = step.faces
    return Rig(found.mesh, deltas, face.rig.names)
