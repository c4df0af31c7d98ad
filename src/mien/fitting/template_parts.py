"""The bundled topology as a template: what of it a scan can show, and what goes along with what is shown."""

from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from ..faces.bundled import BundledFace
from ..mesh import Attachment, Mesh, nearest_along_edges, submesh, vertex_normals
from ..pictures.raycast import RayCaster
from ..register import procrustes
from ..register.nonrigid import Template
from ..register.residuals import laplacian_term, membrane_term, point_term
from ..register.shape import local_rotations, turned_edges
from ..register.solver import solve_vertices

EDGE_MM = 4.0
"""How far from the edges of lids and lips a closest point may be on the wrong one."""

UNREACHED_MM = 1e6
"""Where no way leads: another part."""
SIDE_MM = 8.0
"""So far from the edge of a lip or lid, along the skin, a vertex belongs to it."""
CORNER_MM = 2.0
"""A vertex whose ways to both edges differ by no more is at a corner of the opening, and of both sides."""
REACH_MM = 12.0
"""Hidden skin goes with the shown skin within so far of it."""
NEIGHBOURS = 60
"""... with the nearest so many vertices at most."""
OPENINGS = (
    ("upper_lip", "lower_lip"), ("left_upper_lid", "left_lower_lid"), ("right_upper_lid", "right_lower_lid"),
)  # fmt: skip
"""Contours that close on each other."""


class TemplateParts:
    """Which vertices of the bundled topology a scan can show, and which move as rigid parts."""

    def __init__(self, face: BundledFace):
        self.face = face
        self.skin_faces: Int[np.ndarray, " f"] = face.skin_faces
        skin, self.skin = submesh(face.rig.neutral, self.skin_faces)
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

    def trusted(self, off_face: float) -> Float[np.ndarray, " n"]:
        """`trust`, with 1 wherever the face itself is shown and no more than `off_face` beyond it."""
        return np.maximum(self.face.regions["face"], off_face * self.trust) * (self.trust > 0)

    @cached_property
    def in_the_open(self) -> Int[np.ndarray, " m"]:
        """Triangles of the whole face that are skin which a scan can show."""
        return np.flatnonzero((self.trust[self.face.rig.neutral.faces] > 0).all(axis=1))

    @cached_property
    def sides(self) -> Int[np.ndarray, " n"]:
        """+1 and -1 along upper and lower lip, +2 and -2 along the left eye's lids, +3 and -3 the right one's.

        Measured along the skin, since lips touch: 0 beyond `SIDE_MM` of an edge, and at the corners, where both meet.
        """
        mesh, contours = self.face.rig.neutral, self.face.contours
        sides = np.zeros(len(mesh.vertices), int)
        for value, (upper, lower) in enumerate(OPENINGS, 1):
            if not len(contours.get(upper, ())):
                continue
            above, below = (_along_skin(mesh, contours[name]) for name in (upper, lower))
            near = np.minimum(above, below) < SIDE_MM
            clear = np.abs(above - below) > CORNER_MM
            sides = np.where(near & clear, np.where(above < below, value, -value), sides)
        return sides

    def attached(self, attachment: Attachment) -> Attachment:
        """An attachment to the whole mesh as one to the skin alone."""
        place = np.searchsorted(self.skin_faces, attachment.faces)
        return Attachment(np.minimum(place, len(self.skin_faces) - 1), attachment.barycentric)


def _ears(rest: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, " n"]:
    """Ears and the skin round them on the average face: closest points fold them onto the head."""
    x, y, z = rest.T
    return (np.abs(x) > 66) & (z > -45) & (z < 16) & (y > -50) & (y < 38)


def _along_skin(mesh: Mesh, seeds: Int[np.ndarray, " k"]) -> Float[np.ndarray, " n"]:
    """How far each vertex is from the nearest of `seeds` along the edges, mm."""
    return np.minimum(nearest_along_edges(mesh, seeds)[1], UNREACHED_MM)


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


def extrapolate_hidden(
    template: Template,
    vertices: Float[np.ndarray, "n 3"],
    shown: Bool[np.ndarray, " n"],
    sides: Int[np.ndarray, " n"] | None = None,
) -> Float[np.ndarray, "n 3"]:
    """Hidden skin (the mouth's inside, nostrils, behind the lids, ears) goes with the shown skin around it.

    Shape terms alone would leave the mouth's lining where it was while the cheek moves in over it. So every hidden
    vertex is drawn to its rest place moved as the shown skin around it is, and the shape terms smooth that.

    Args:
        sides: of two lips or lids, as in `TemplateParts.sides`: the lining of one does not go with the other.
    """
    rest = template.mesh.vertices
    if shown.all() or not shown.any():
        return vertices
    goal = vertices.copy()
    of_hidden = np.zeros(len(rest), int) if sides is None else _sides_along_skin(template.mesh, shown, sides)
    for side in np.unique(of_hidden[~shown]):
        hidden = ~shown & (of_hidden == side)
        around = shown if sides is None or side == 0 else shown & (sides != -side)
        goal[hidden] = rest[hidden] + _motion_around(rest[around], (vertices - rest)[around], rest[hidden])
    hold = np.where(shown, 1e4, 0.3) * template.stencil.mass
    edges = turned_edges(template.stencil, rest, local_rotations(template.stencil, rest, goal))
    terms = [laplacian_term(template.stencil, edges, 1.0, 1.0), membrane_term(template.stencil, edges, 0.02)]
    solved = solve_vertices([*terms, point_term(goal, hold)], None, goal, prolongation=template.prolongation).vertices
    return np.where(shown[:, None], vertices, solved)


def _sides_along_skin(mesh: Mesh, shown: Bool[np.ndarray, " n"], sides: Int[np.ndarray, " n"]) -> Int[np.ndarray, " n"]:
    """The side of the shown vertex that is nearest along the edges; 0 where no way leads to one."""
    nearest, _ = nearest_along_edges(mesh, np.flatnonzero(shown))
    return np.where(nearest >= 0, sides[np.maximum(nearest, 0)], 0)


def _motion_around(
    places: Float[np.ndarray, "k 3"], motion: Float[np.ndarray, "k 3"], points: Float[np.ndarray, "p 3"]
) -> Float[np.ndarray, "p 3"]:
    """How what is at `places` moves about each of `points`, on average, mm."""
    found = KDTree(places).query(points, k=min(NEIGHBOURS, len(places)))
    near, who = (np.reshape(part, (len(points), -1)) for part in found)
    weights = np.exp(-((near / REACH_MM) ** 2)) + 1e-6 / (1 + near**2)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.einsum("pk,pkd->pd", weights, motion[who])


def move_rigid_parts(
    parts: dict[str, Int[np.ndarray, " _"]],
    skin: Int[np.ndarray, " k"],
    shown: Bool[np.ndarray, " k"],
    before: Float[np.ndarray, "n 3"],
    after: Float[np.ndarray, "n 3"],
) -> Float[np.ndarray, "n 3"]:
    """`after` with eyeballs riding on their lids, teeth and tongue on the `shown` skin before them, rigidly."""
    vertices = after.copy()
    for part, members in parts.items():
        if part == "skin":
            continue
        centre = before[members].mean(axis=0)
        reach = 18.0 if part.endswith("eye") else 30.0
        off = np.linalg.norm(before[skin] - centre, axis=1)
        moved = procrustes(before[skin], after[skin], np.exp(-((off / reach) ** 2)) * shown).transform
        vertices[members] = moved.apply(before[members])
    return vertices
