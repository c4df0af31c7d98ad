"""One scan, no markers: the bundled topology on it (after Huang 2011, sec. 6.1, with landmarks for markers)."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from ..mesh import Attachment, Mesh, Scan, closest_point, submesh, vertex_normals
from ..pictures.raycast import RayCaster
from ..pictures.refine import loop_refinement
from ..progress import SILENT, Progress
from ..register import procrustes
from ..register.correspond import Rejection, Surface
from ..register.morph import LinearModel, MorphConfig, fit_model
from ..register.nonrigid import Anchors, NonrigidConfig, Template
from ..register.residuals import laplacian_term, membrane_term, point_term
from ..register.shape import local_rotations, turned_edges
from ..register.solver import solve_vertices
from ..transforms import Transform
from .bundled import BundledFace, load_face
from .landmark_lift import Landmarks3D, LiftConfig, lift_landmarks
from .landmarks import LandmarkSet, bundled_landmarks
from .scan_clean import cleaned

SET_ASIDE = ("eyeLook", "tongueOut", "mouthClose")
"""Shapes that a scan's surface says nothing of, by the beginnings of their names."""


@dataclass(frozen=True)
class RegisterConfig:
    """How one scan is registered. Millimetres throughout."""

    density: int = 0
    """Rounds of subdivision of the result; each has four times the triangles."""
    score_share: float = 0.7
    """Expected weight of an expression, as a share of MediaPipe's score for it; 0 expects a neutral face."""
    expression_spread: float = 0.25
    """Standard deviation of an expression's weight about that."""
    identity_spread: float = 1.2
    """Standard deviation of the identity's coefficients: 1 is the people that the space was made from."""
    off_face: float = 0.15
    """Trust in closest points on outer skin beyond the face (neck, scalp, ears), against 1 on the face."""
    reliable: float = 0.6
    """A vertex is reliable where the scan is no farther away than this."""
    landmark_slack: float = 4.0
    """A landmark this far from the fitted model's counts a quarter, mm."""
    lift: LiftConfig = field(default_factory=LiftConfig)
    morph: MorphConfig = field(default_factory=MorphConfig)
    first: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            markers=2.0, closest=(0.01, 0.03), coarse=(), rounds=2, rejection=Rejection(max_distance=8.0)
        )
    )
    """The stiff rounds, in which all landmarks pull."""
    second: NonrigidConfig = field(
        default_factory=lambda: NonrigidConfig(
            markers=1.0, closest=(0.1, 0.5, 2.0), coarse=(), rejection=Rejection(max_distance=4.0)
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


def register_scan(
    scan: Scan,
    face: BundledFace | None = None,
    landmarks: Landmarks3D | None = None,
    config: RegisterConfig | None = None,
    progress: Progress = SILENT,
) -> Registration:
    """The bundled face's topology on a scan: find landmarks, fit the model, then the surface.

    Raises:
        BadInput: no face in the scan, or more than one head.
    """
    face, config = face or load_face(), config or RegisterConfig()
    progress.update("registering", 0, 4)
    landmarks = landmarks or lift_landmarks(scan, config.lift)
    body = _TemplateParts(face)
    target = cleaned(scan.mesh.with_vertices(landmarks.T_face_scan.apply(scan.mesh.vertices)))
    progress.update("registering", 1, 4)
    anchors = _anchors(landmarks, bundled_landmarks(), landmarks.T_face_scan.apply(landmarks.points))
    fitted, identity, weights = _fit_model(face, body, Surface(target), anchors, landmarks.scores, config)
    progress.update("registering", 2, 4)
    T_face_scan = fitted.T_model_target @ landmarks.T_face_scan
    surface = Surface(target.with_vertices(fitted.T_model_target.apply(target.vertices)))
    anchors = replace(anchors, points=fitted.T_model_target.apply(anchors.points))
    anchors = _believed(anchors, face.rig.neutral.with_vertices(fitted.vertices), config.landmark_slack)
    mesh = _shrink_wrap(face, body, fitted.vertices, surface, anchors, config)
    progress.update("registering", 3, 4)
    mesh, trust = _refined(face, body, mesh, surface, anchors, config)
    distances, reliable = _quality(mesh, surface, trust, config)
    regions = _region_errors(face, config.density, distances, reliable)
    progress.update("registering", 4, 4)
    return Registration(mesh, T_face_scan, distances, reliable, regions, landmarks, identity, weights)


class _TemplateParts:
    """Which vertices of the bundled topology a scan can show, and which move as rigid parts."""

    def __init__(self, face: BundledFace):
        self.face = face
        mesh = face.rig.neutral
        on_skin = np.zeros(len(mesh.vertices), bool)
        on_skin[face.parts["skin"]] = True
        self.skin_faces: Int[np.ndarray, " f"] = np.flatnonzero(on_skin[mesh.faces].all(axis=1))
        skin, self.skin = submesh(mesh, self.skin_faces)
        self.skin_triangles = skin.faces

    @cached_property
    def trust(self) -> Float[np.ndarray, " n"]:
        """1 in the open, 0 where a scan shows nothing or closest points go wrong; less along lids and lips."""
        rest = self.face.rig.neutral.vertices
        trust = _openness(self.face) * ~_ears(rest)
        edges = [rest[c] for c in self.face.contours.values() if len(c)]
        if edges:
            off = KDTree(np.concatenate(edges)).query(rest)[0]
            trust = trust * (0.3 + 0.7 * np.clip(off / EDGE_MM, 0, 1))
        return trust

    def attached(self, attachment: Attachment) -> Attachment:
        """An attachment to the whole mesh as one to the skin alone."""
        place = np.searchsorted(self.skin_faces, attachment.faces)
        return Attachment(np.minimum(place, len(self.skin_faces) - 1), attachment.barycentric)


def _ears(rest: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Ears and the skin round them on the average face: closest points fold them onto the head."""
    x, y, z = rest.T
    return (np.abs(x) > 66) & (z > -45) & (z < 16) & (y > -50) & (y < 38)


def _openness(face: BundledFace, directions: int = 64) -> Float[np.ndarray, " n"]:
    """0 in caves (mouth, nostrils, behind the lids and ears), 1 in the open, on the skin; 0 on other parts."""
    mesh = face.rig.neutral
    normals = vertex_normals(mesh.vertices, mesh.faces)
    i = np.arange(directions) + 0.5
    up, turn = 1 - 2 * i / directions, np.pi * (1 + 5**0.5) * i
    rays = np.stack([np.sqrt(1 - up**2) * np.cos(turn), np.sqrt(1 - up**2) * np.sin(turn), up], 1)
    caster, free, count = RayCaster(mesh), np.zeros(len(normals)), np.zeros(len(normals))
    for ray in rays:
        before = normals @ ray > 0.1
        start = mesh.vertices[before] + 0.05 * normals[before]
        free[before] += ~caster.occluded(start, np.broadcast_to(ray, start.shape))
        count += before
    found = np.zeros(len(normals))
    skin = face.parts["skin"]
    found[skin] = np.clip((free / np.maximum(count, 1))[skin] / 0.5 - 0.3, 0, 1)
    return found


def _anchors(landmarks: Landmarks3D, landmark_set: LandmarkSet, points: np.ndarray) -> Anchors:
    """Landmarks with a weight each: less where views disagree, none on outline and irises."""
    weights = np.zeros(len(points))
    seen = np.isfinite(points.sum(axis=1))
    steady = landmark_set.stable[seen[landmark_set.stable]]
    weights[steady] = 1 / (1 + (landmarks.spread[steady] / 1.5) ** 2)
    return Anchors(landmark_set.attachment, np.nan_to_num(points), weights)


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


def _fit_model(face: BundledFace, body: _TemplateParts, surface: Surface, anchors: Anchors, scores, config):
    """Identity, expression and pose; lids and eyes are refitted to the person half-way."""
    names = [n for n in face.rig.names if not n.startswith(SET_ASIDE)]
    shapes = [face.rig.index(n) for n in names]
    people = len(face.identity.modes)
    expected = np.r_[np.zeros(people), [config.score_share * scores.get(n, 0.0) for n in names]]
    spread = np.r_[np.full(people, config.identity_spread), np.full(len(names), config.expression_spread)]
    low = np.r_[np.full(people, -3.5), np.zeros(len(names))]
    high = np.r_[np.full(people, 3.5), np.ones(len(names))]
    neutral, deltas = face.rig.neutral, face.rig.deltas
    trust = face.regions["face"] * (body.trust > 0)
    for _ in range(2):
        modes = np.concatenate([face.identity.modes, deltas[shapes]])
        model = LinearModel(neutral.vertices, neutral.faces, modes, expected, spread, low, high)
        fitted = fit_model(model, surface, anchors, trust, config.morph)
        identity = fitted.coefficients[:people]
        deltas = face.fitted_deltas(neutral.vertices + face.identity.displacement(identity))
    return fitted, identity, dict(zip(names, fitted.coefficients[people:].tolist(), strict=True))


EDGE_MM = 4.0
"""How far from the edges of lids and lips a closest point may be on the wrong one."""
LIPS_AND_LIDS = ("lips_outer", "lips_inner", "eye_left", "eye_right")


def _shrink_wrap(face, body: _TemplateParts, start: np.ndarray, surface: Surface, anchors: Anchors, config) -> Mesh:
    """Eq. 7 on the skin, stiff and then soft; eyes, teeth and tongue follow as rigid parts."""
    whole = face.rig.neutral.with_vertices(start)
    template = Template(Mesh(start[body.skin], body.skin_triangles))
    trust = _trust(face, body, config)[body.skin]
    held = replace(anchors, attachment=body.attached(anchors.attachment))
    found = template.register(surface, held, config.first, trust=trust)
    held = _of_groups(held, LIPS_AND_LIDS)
    found = template.register(surface, held, config.second, start=found.vertices, trust=trust)
    vertices = start.copy()
    vertices[body.skin] = carried(template, found.vertices, trust > 0)
    return whole.with_vertices(_parts_follow(face, body, start, vertices))


def carried(
    template: Template, vertices: Float[np.ndarray, "n 3"], shown: Bool[np.ndarray, " n"], reach: float = 12.0
) -> Float[np.ndarray, "n 3"]:
    """Hidden skin (the mouth's inside, nostrils, behind the lids, ears) goes with the shown skin around it.

    Shape terms alone would leave the mouth's lining where it was while the cheek moves in over it. So every hidden
    vertex is drawn to its rest place moved as the shown skin within `reach` mm is, and the shape terms smooth that.
    """
    hidden, rest = np.flatnonzero(~shown), template.mesh.vertices
    if not len(hidden) or not shown.any():
        return vertices
    near, who = KDTree(rest[shown]).query(rest[hidden], k=min(60, int(shown.sum())))
    weights = np.exp(-((near / reach) ** 2)) + 1e-6 / (1 + near**2)
    weights /= weights.sum(axis=1, keepdims=True)
    moved = (vertices - rest)[shown]
    goal = vertices.copy()
    goal[hidden] = rest[hidden] + np.einsum("hk,hkd->hd", weights, moved[who])
    hold = np.where(shown, 1e4, 0.3) * template.stencil.mass
    edges = turned_edges(template.stencil, rest, local_rotations(template.stencil, rest, goal))
    terms = [laplacian_term(template.stencil, edges, 1.0, 1.0), membrane_term(template.stencil, edges, 0.02)]
    solved = solve_vertices([*terms, point_term(goal, hold)], None, goal).vertices
    return np.where(shown[:, None], vertices, solved)


def _parts_follow(face: BundledFace, body: _TemplateParts, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Eyeballs ride on their lids, teeth and tongue on the skin before them, rigidly."""
    vertices = after.copy()
    for part, members in face.parts.items():
        if part == "skin":
            continue
        centre = before[members].mean(axis=0)
        reach = 18.0 if part.endswith("eye") else 30.0
        off = np.linalg.norm(before[body.skin] - centre, axis=1)
        weights = np.exp(-((off / reach) ** 2)) * (body.trust[body.skin] > 0)
        moved = procrustes(before[body.skin], after[body.skin], weights).transform
        vertices[members] = moved.apply(before[members])
    return vertices


def _refined(face, body: _TemplateParts, mesh: Mesh, surface: Surface, anchors: Anchors, config):
    """Subdivide and register again, `density` times: the mesh, and the trust of its vertices."""
    trust, is_skin = _trust(face, body, config), np.zeros(len(mesh.vertices))
    is_skin[face.parts["skin"]] = 1.0
    held = _of_groups(anchors, LIPS_AND_LIDS)
    for _ in range(config.density):
        points = held.attachment.points(mesh)
        step = loop_refinement(mesh.faces, len(mesh.vertices))
        trust, is_skin = step.between @ trust, step.between @ is_skin
        mesh = _subdivided(mesh, step)
        on_skin = np.flatnonzero((is_skin[mesh.faces] == 1).all(axis=1))
        skin, members = submesh(mesh, on_skin)
        there = closest_point(skin, points).attachment()
        on_part = replace(held, attachment=there)
        found = Template(skin, 0).register(surface, on_part, config.fine, trust=trust[members])
        vertices = mesh.vertices.copy()
        vertices[members] = found.vertices
        mesh = mesh.with_vertices(vertices)
        held = replace(held, attachment=Attachment(on_skin[there.faces], there.barycentric))
    return mesh, trust


def _trust(face: BundledFace, body: _TemplateParts, config: RegisterConfig) -> Float[np.ndarray, " n"]:
    return np.maximum(face.regions["face"], config.off_face * body.trust) * (body.trust > 0)


def _subdivided(mesh: Mesh, step) -> Mesh:
    uv, uv_faces = mesh.uv, mesh.uv_faces
    if uv is not None and uv_faces is not None:
        corners = step.corners(uv[uv_faces])
        uv, inverse = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
        uv_faces = inverse.reshape(-1, 3)
    colors = None if mesh.colors is None else step.between @ mesh.colors
    return Mesh(step.matrix @ mesh.vertices, step.faces, uv, uv_faces, colors)


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
