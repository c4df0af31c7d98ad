"""The template of many scans: the bundled topology on the neutral one, or any mesh of a face (Huang 2011, sec. 6)."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from ..faces.bundled import BundledFace
from ..fitting.template_parts import TemplateParts, extrapolate_hidden, move_rigid_parts
from ..mesh import Attachment, Mesh, closest_point, in_largest_part, submesh
from ..mesh.subdivide import loop_refinement
from ..register import NonrigidConfig, Surface, Template
from ..rig import Rig

FINE_REGIONS: tuple[str, ...] = (
    "forehead_left", "forehead_right", "eye_left", "eye_right", "cheek_left", "cheek_right", "mouth", "chin",
)  # fmt: skip
"""The regions of the fine-scale step (sec. 6.2, fig. 6)."""

OFF_TEMPLATE_MM = 3.0
"""A mesh so far off the bundled face's begins to lose its regions, and has lost them at twice as much."""
CONTOUR_STEPS = 8
"""Points on each side of a contour's polygon, for distances to it."""
SURE = 0.5
"""Trust below which a vertex counts as on an edge: the backs of lids and lips."""
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
    skin: Mesh
    """The skin alone."""
    trust: Float[np.ndarray, " n"]
    """How far closest points of the skin's vertices are believed: 0 in caves, 1 on the open face."""
    regions: dict[str, Float[np.ndarray, " n"]]
    """Masks over the skin's vertices: `face` and the eight of the fine-scale step."""
    parts: dict[str, Int[np.ndarray, " _"]]
    """Vertices of each eye, the teeth and the tongue."""
    fine_weight: Float[np.ndarray, " n"]
    """0 at the edges of lids and lips, 1 some millimetres off: there are no features to follow on an edge."""
    mobility: Float[np.ndarray, " n"]
    """How far the bundled face's shapes move each of the skin's vertices, rms over the shapes, mm."""
    sides: Int[np.ndarray, " n"]
    """Which of two lips or lids each vertex is of (see `register.sides`); 0 elsewhere."""
    person: Rig | None = None
    """The bundled face's skin on the reference scan, not subdivided, with its expressions."""

    @cached_property
    def body(self) -> Template:
        """The skin made ready to be deformed."""
        return Template(self.skin)

    @cached_property
    def shown(self) -> Bool[np.ndarray, " n"]:
        """Skin that scans show."""
        return self.trust > 0

    @cached_property
    def in_the_open(self) -> Int[np.ndarray, " m"]:
        """Triangles of `mesh` that are skin which scans show."""
        return self.skin_faces[self.shown[self.skin.faces].all(axis=1)]

    def attachment_of(self, skin: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "p 3"]) -> Attachment:
        """The points of the shown skin, now at `skin`, closest to `points` (mm)."""
        faces = self.skin.faces
        shown = np.flatnonzero(self.shown[faces].all(axis=1))
        found = closest_point(Mesh(skin, faces[shown]), points)
        return Attachment(shown[found.faces], found.barycentric)

    def whole(self, skin: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "all 3"]:
        """All vertices when the skin is at `skin`: what lies hidden goes with what is shown, parts ride rigidly."""
        before, after = self.mesh.vertices, self.mesh.vertices.copy()
        after[self.members] = extrapolate_hidden(self.body, skin, self.shown, self.sides)
        return move_rigid_parts(self.parts, self.members, self.shown, before, after)


def make_template(mesh: Mesh, face: BundledFace, off_face: float = 0.15) -> ScanTemplate:
    """A template of a mesh that has the bundled topology, subdivided any number of times (face space, mm)."""
    names = ("face", *FINE_REGIONS)
    parts = {name: _mask(part, len(face.rig.neutral.vertices)) for name, part in face.parts.items()}
    body = TemplateParts(face)
    masks = np.stack([body.trusted(off_face), *(face.regions[name] for name in names), *parts.values()], 1)
    faces, spread = face.rig.neutral.faces, sp.csr_matrix(sp.identity(len(masks)))
    while len(faces) < len(mesh.faces):
        step = loop_refinement(faces, len(masks))
        faces, masks, spread = step.faces, step.between @ masks, sp.csr_matrix(step.matrix @ spread)
    trust, in_region, in_part = masks[:, 0], masks[:, 1 : 1 + len(names)], masks[:, 1 + len(names) :]
    members_of = {name: np.flatnonzero(column == 1.0) for name, column in zip(parts, in_part.T, strict=True)}
    on_skin = _mask(members_of.pop("skin"), len(trust)) > 0
    skin_faces = np.flatnonzero(on_skin[mesh.faces].all(axis=1))
    skin, members = submesh(mesh, skin_faces)
    from_bundled = sp.csr_matrix(spread[members])
    moved = [((from_bundled @ delta) ** 2).sum(axis=1) for delta in face.rig.deltas]
    return ScanTemplate(
        mesh=mesh,
        skin_faces=skin_faces,
        members=members,
        skin=skin,
        trust=trust[members],
        regions={name: in_region[members, i] for i, name in enumerate(names)},
        parts=members_of,
        fine_weight=_fine_weight(mesh.vertices, trust, face)[members],
        mobility=np.sqrt(np.mean(moved, axis=0)),
        sides=_carried_sides(from_bundled, body.sides),
        person=person_on(mesh, face),
    )


def person_on(mesh: Mesh, face: BundledFace) -> Rig:
    """The bundled face's skin, and how it moves, where its coarse vertices, the first, are on a mesh."""
    neutral = face.rig.neutral.with_vertices(mesh.vertices[: len(face.rig.neutral.vertices)])
    deltas = face.fitted_deltas(neutral.vertices)
    skin, members = submesh(neutral, face.skin_faces)
    return Rig(skin, deltas[:, members], face.rig.names)


def _carried_sides(carry: sp.csr_matrix, sides: Int[np.ndarray, " k"]) -> Int[np.ndarray, " n"]:
    """Sides of points that are averages (rows of `carry`) of vertices whose sides are known: what most of it is of."""
    values = np.unique(sides)
    votes = np.stack([carry @ (sides == value) for value in values], axis=1)
    return values[votes.argmax(axis=1)]


def _fine_weight(
    vertices: Float[np.ndarray, "n 3"], trust: Float[np.ndarray, " n"], face: BundledFace
) -> Float[np.ndarray, " n"]:
    """Less the less a vertex is trusted: the backs of lids and lips are as good as on the edge.

    Coarse vertices come first, so that the contours' numbers hold at any density.
    """
    lines = [vertices[edge] for edge in face.contours.values() if len(edge)]
    if not lines:
        return np.ones(len(vertices))
    between = [
        (line[:-1, None] + np.linspace(0, 1, CONTOUR_STEPS)[:, None] * (line[1:] - line[:-1])[:, None])
        for line in lines
    ]
    away = KDTree(np.concatenate([b.reshape(-1, 3) for b in between])).query(vertices)[0]
    return 1 - np.exp(-((away * np.clip((trust - SURE) / (1 - SURE), 0, 1) / EDGE_MM) ** 2))


def own_template(mesh: Mesh, bundled: ScanTemplate) -> ScanTemplate:
    """A template of any mesh that lies on the reference scan, as one of the scans does (face space, mm).

    Regions and trust are the bundled template's at the closest points; everything counts as skin.
    """
    there = closest_point(bundled.skin, mesh.vertices)
    D = there.attachment().matrix(bundled.skin)
    near = np.clip(2 - there.distances / OFF_TEMPLATE_MM, 0, 1)
    return ScanTemplate(
        mesh=mesh,
        skin_faces=np.arange(len(mesh.faces)),
        members=np.arange(len(mesh.vertices)),
        skin=mesh,
        trust=near * np.maximum(D @ bundled.trust, 0.0),
        regions={name: near * (D @ mask) for name, mask in bundled.regions.items()},
        parts={},
        fine_weight=D @ bundled.fine_weight,
        mobility=D @ bundled.mobility,
        sides=_carried_sides(D, bundled.sides),
        person=bundled.person,
    )


def manifold_part(mesh: Mesh) -> Mesh:
    """What of a mesh is fit for a template: the largest piece, without forks.

    Triangles go that are at edges of more than two, and at vertices where the surface touches itself.
    """
    faces, before = mesh.faces, -1
    while len(faces) != before:
        before = len(faces)
        faces = _without_forks(faces, len(mesh.vertices))
        faces = faces[in_largest_part(faces, len(mesh.vertices))]
    return submesh(replace(mesh, faces=faces, uv=None, uv_faces=None), np.arange(len(faces)))[0]


def _without_forks(faces: Int[np.ndarray, "m 3"], n: int) -> Int[np.ndarray, "k 3"]:
    """Without triangles on an edge that another one walks the same way, or at a vertex that two rims pass."""
    directed = faces[:, [[0, 1], [1, 2], [2, 0]]].astype(np.int64)
    keys = directed[..., 0] * n + directed[..., 1]
    _, which, count = np.unique(keys, return_inverse=True, return_counts=True)
    once = (count[which].reshape(keys.shape) == 1).all(axis=1)
    rim = ~np.isin(keys, directed[..., 1] * n + directed[..., 0])
    leaving = np.bincount(directed[..., 0][rim], minlength=n)
    return faces[once & (leaving[faces] < 2).all(axis=1)]


def transfer_topology(
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
