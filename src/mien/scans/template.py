"""The bundled topology as the template of many scans: made on the calmest one, deformed to all (Huang 2011, sec. 6)."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from ..faces.bundled import BundledFace
from ..fitting.register_scan import LIPS_AND_LIDS
from ..fitting.template_parts import TemplateParts, extrapolate_hidden, move_rigid_parts
from ..landmarks.detector import bundled_landmarks
from ..mesh import Attachment, Mesh, adjacency, closest_point, submesh
from ..mesh.subdivide import loop_refinement
from ..register import Anchors, NonrigidConfig, Surface, Template

EIGHT: tuple[str, ...] = (
    "forehead_left", "forehead_right", "eye_left", "eye_right", "cheek_left", "cheek_right", "mouth", "chin",
)  # fmt: skip
"""The regions of the fine-scale step (sec. 6.2, fig. 6)."""

EDGE_MM = 3.0
"""How far from the edges of lids and lips the fine-scale step fades."""


@dataclass(frozen=True)
class ScanTemplate:
    """A mesh in the bundled topology (subdivided or not), and which of it scans show."""

    mesh: Mesh
    """On the reference scan, face space, mm; eyes and teeth too."""
    skin_faces: Int[np.ndarray, " f"]
    """Triangles of skin."""
    members: Int[np.ndarray, " n"]
    """Vertices of skin: the rows of `skin`'s vertices in `mesh`."""
    skin: Template
    """The skin alone, made ready to be deformed."""
    trust: Float[np.ndarray, " n"]
    """How far closest points of the skin's vertices are believed: 0 in caves, 1 on the open face."""
    regions: dict[str, Float[np.ndarray, " n"]]
    """Masks over the skin's vertices: `face` and the eight of the fine-scale step."""
    parts: dict[str, Int[np.ndarray, " _"]]
    """Vertices of each eye, the teeth and the tongue."""
    off_edges: Float[np.ndarray, " n"]
    """0 at the edges of lids and lips, 1 some millimetres off: there are no features to follow on an edge."""

    @cached_property
    def shown(self) -> Bool[np.ndarray, " n"]:
        """Skin that scans show."""
        return self.trust > 0

    def attach(self, skin: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "p 3"]) -> Attachment:
        """The points of the shown skin, now at `skin`, closest to `points` (mm)."""
        faces = self.skin.mesh.faces
        shown = np.flatnonzero(self.shown[faces].all(axis=1))
        found = closest_point(Mesh(skin, faces[shown]), points)
        return Attachment(shown[found.faces], found.barycentric)

    def whole(self, skin: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "all 3"]:
        """All vertices when the skin is at `skin`: what lies hidden goes with what is shown, parts ride rigidly."""
        before, after = self.mesh.vertices, self.mesh.vertices.copy()
        after[self.members] = extrapolate_hidden(self.skin, skin, self.shown)
        return move_rigid_parts(self.parts, self.members, self.shown, before, after)


def make_template(mesh: Mesh, face: BundledFace, off_face: float = 0.15) -> ScanTemplate:
    """A template of a mesh that has the bundled topology, subdivided any number of times (face space, mm)."""
    masks = {name: face.regions[name] for name in ("face", *EIGHT)}
    trust = TemplateParts(face).trusted(off_face)
    kinds = {name: _mask(part, len(trust)) for name, part in face.parts.items()}
    faces, values = face.rig.neutral.faces, np.stack([trust, *masks.values(), *kinds.values()], 1)
    while len(faces) < len(mesh.faces):
        step = loop_refinement(faces, len(values))
        faces, values = step.faces, step.between @ values
    trust, masks, kinds = values[:, 0], values[:, 1 : 1 + len(masks)], values[:, 1 + len(masks) :]
    parts = dict(zip(face.parts, (np.flatnonzero(kind == 1.0) for kind in kinds.T), strict=True))
    on_skin = _mask(parts.pop("skin"), len(trust)) > 0
    skin_faces = np.flatnonzero(on_skin[mesh.faces].all(axis=1))
    skin, members = submesh(mesh, skin_faces)
    regions: dict[str, np.ndarray] = {name: masks[members, i] for i, name in enumerate(("face", *EIGHT))}
    off_edges = _off_edges(mesh.vertices, trust, face)[members]
    return ScanTemplate(mesh, skin_faces, members, Template(skin), trust[members], regions, parts, off_edges)


def _off_edges(
    vertices: Float[np.ndarray, "n 3"], trust: Float[np.ndarray, " n"], face: BundledFace
) -> Float[np.ndarray, " n"]:
    """Less the less a vertex is trusted: the backs of lids and lips are as good as on the edge.

    Coarse vertices come first, so that the contours' numbers hold at any density.
    """
    lines = [vertices[edge] for edge in face.contours.values() if len(edge)]
    if not lines:
        return np.ones(len(vertices))
    between = [(line[:-1, None] + np.linspace(0, 1, 8)[:, None] * (line[1:] - line[:-1])[:, None]) for line in lines]
    away = KDTree(np.concatenate([b.reshape(-1, 3) for b in between])).query(vertices)[0]
    return 1 - np.exp(-((away * np.clip(2 * trust - 1, 0, 1) / EDGE_MM) ** 2))


def own_template(mesh: Mesh, bundled: ScanTemplate) -> ScanTemplate:
    """A template of any mesh that lies on the reference scan, as one of the scans does (face space, mm).

    Regions and trust are the bundled template's at the closest points; everything counts as skin.
    """
    there = closest_point(bundled.skin.mesh, mesh.vertices)
    D = there.attachment().matrix(bundled.skin.mesh)
    near = np.clip(2 - there.distances / 3.0, 0, 1)
    regions = {name: near * (D @ mask) for name, mask in bundled.regions.items()}
    everything, all_faces = np.arange(len(mesh.vertices)), np.arange(len(mesh.faces))
    trust = near * np.maximum(D @ bundled.trust, 0.0)
    return ScanTemplate(mesh, all_faces, everything, Template(mesh), trust, regions, {}, D @ bundled.off_edges)


def sound(mesh: Mesh) -> Mesh:
    """Fit for a template: the largest piece, without triangles at edges of more than two, nor at vertices where the
    surface touches itself."""
    faces, before = mesh.faces, -1
    while len(faces) != before:
        before = len(faces)
        faces = _largest(_untangled(faces, len(mesh.vertices)), len(mesh.vertices))
    return submesh(replace(mesh, faces=faces, uv=None, uv_faces=None), np.arange(len(faces)))[0]


def _untangled(faces: Int[np.ndarray, "m 3"], n: int) -> Int[np.ndarray, "k 3"]:
    """Without triangles on an edge that another one walks the same way, or at a vertex that two rims pass."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].astype(np.int64)
    keys = directed[..., 0] * n + directed[..., 1]
    _, which, count = np.unique(keys, return_inverse=True, return_counts=True)
    once = (count[which].reshape(keys.shape) == 1).all(axis=1)
    rim = ~np.isin(keys, directed[..., 1] * n + directed[..., 0])
    leaving = np.bincount(directed[..., 0][rim], minlength=n)
    return faces[once & (leaving[faces] < 2).all(axis=1)]


def _largest(faces: Int[np.ndarray, "m 3"], n: int) -> Int[np.ndarray, "k 3"]:
    _, piece = connected_components(adjacency(faces, n), directed=False)
    of_face = piece[faces[:, 0]]
    return faces[of_face == np.bincount(of_face).argmax()]


def laid_over(
    mesh: Mesh, on_mesh: Mesh, on_reference: Mesh, target: Surface, config: NonrigidConfig | None = None
) -> Mesh:
    """Any mesh brought onto the reference scan by way of the bundled topology, which lies on both.

    Args:
        mesh: face space, mm.
        on_mesh: the bundled topology registered to it.
        on_reference: the same registered to the reference scan.
        target: that scan, face space, mm.
    """
    held = closest_point(on_mesh, mesh.vertices).attachment()
    start = mesh.vertices + held.points(on_reference) - held.points(on_mesh)
    settings = config or NonrigidConfig(coarse=())
    return mesh.with_vertices(Template(mesh).register(target, None, settings, start).vertices)


def _mask(members: np.ndarray, n: int) -> Float[np.ndarray, " n"]:
    mask = np.zeros(n)
    mask[members] = 1.0
    return mask


@dataclass(frozen=True)
class CoarseConfig:
    """The large-scale step (sec. 6.1, eq. 7), with the paper's weights."""

    nonrigid: NonrigidConfig = field(default_factory=lambda: NonrigidConfig(coarse=()))
    """w1 = 10000, w2 = 1, w3 = 0.1, 0.5, 2."""
    landmarks: float = 0.1
    """Weight of lip and lid landmarks, against `nonrigid.markers` of a marker; 0: none, as in the paper."""
    landmark_slack: float = 1.5
    """A landmark on which the views disagree by this much counts half, mm."""


@dataclass(frozen=True)
class Landmarks:
    """Lips and lids as a detector sees them on a scan."""

    points: Float[np.ndarray, "478 3"]
    """Face space, mm; NaN where not seen."""
    spread: Float[np.ndarray, " 478"]
    """How far the views disagree, mm."""


def deform(
    template: ScanTemplate,
    surface: Surface,
    attachment: Attachment,
    markers: Float[np.ndarray, "markers 3"],
    covered: Bool[np.ndarray, " markers"],
    seen: tuple[Landmarks, Landmarks] | None = None,
    config: CoarseConfig = CoarseConfig(),
) -> Float[np.ndarray, "n 3"]:
    """The template's skin on one scan: eq. 7, markers to markers, then the surface three times, ever more firmly.

    Beside the paper: lips and lids, which have few markers or none, are held by landmarks, on the template where the
    detector saw them on the reference scan, so that its own bias takes itself off.

    Args:
        surface: the scan in face space, mm.
        attachment: markers' skin points on the template's skin.
        markers: the same on the scan.
        seen: landmarks on the reference scan and on this one.
    """
    weights = covered.astype(float)
    anchors = Anchors(attachment, markers, weights)
    if seen is not None and config.landmarks:
        anchors = _joined(anchors, _landmark_anchors(template, *seen, config))
    return template.skin.register(surface, anchors, config.nonrigid, trust=template.trust).vertices


def _landmark_anchors(template: ScanTemplate, there: Landmarks, here: Landmarks, config: CoarseConfig) -> Anchors:
    groups = bundled_landmarks().groups
    used = np.unique(np.concatenate([groups[name] for name in LIPS_AND_LIDS]))
    used = used[np.isfinite(there.points[used]).all(axis=1) & np.isfinite(here.points[used]).all(axis=1)]
    on_template = closest_point(template.skin.mesh, there.points[used]).attachment()
    spread = there.spread[used] ** 2 + here.spread[used] ** 2
    weights = config.landmarks / config.nonrigid.markers / (1 + spread / config.landmark_slack**2)
    return Anchors(on_template, here.points[used], weights)


def _joined(a: Anchors, b: Anchors) -> Anchors:
    attachment = Attachment(
        np.concatenate([a.attachment.faces, b.attachment.faces]),
        np.concatenate([a.attachment.barycentric, b.attachment.barycentric]),
    )
    return Anchors(attachment, np.concatenate([a.points, b.points]), np.concatenate([a.weights, b.weights]))
