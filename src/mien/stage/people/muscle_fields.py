"""What muscles do to skin: displacement fields over one person's neutral face, from anatomy alone, mm.

Fibres run along the skin from bone to insertion; lids turn about the eyeball, the jaw about its joint; lips evert, roll
and press.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from ...faces.bundled import BundledFace
from ...landmarks.detector import bundled_landmarks
from ...mesh import Mesh, adjacency, vertex_normals
from .anatomy import Ball
from .muscle_table import JAW_CARRIED, JAW_FIXED, Pull

SIDES = ("Left", "Right")
SIGN = {"Left": 1.0, "Right": -1.0}
TANGENTIAL = 0.7
"""How much of a pull's part into the head is taken away: skin slides on bone."""
BEYOND = 1.4
"""Skin past the insertion hangs on it: so much of each millimetre there is forgiven, of the two that it counts."""
NECK, NAPE = -138.0, 10.0
"""Below this height and behind this depth (face space, mm) the jaw carries no skin."""


@dataclass(frozen=True)
class SkinMap:
    """One person's neutral skin as muscles know it: points, normals, ways along it, landmarks."""

    mesh: Mesh
    face: BundledFace = field(repr=False)

    @cached_property
    def normals(self) -> Float[np.ndarray, "n 3"]:
        """Outward, unit."""
        return vertex_normals(self.mesh.vertices, self.mesh.faces)

    @cached_property
    def landmarks(self) -> Float[np.ndarray, "478 3"]:
        """MediaPipe's, mm."""
        return bundled_landmarks().attachment.points(self.mesh)

    @cached_property
    def _graph(self) -> sp.csr_matrix:
        points = self.mesh.vertices
        links = sp.coo_matrix(adjacency(self.mesh.faces, len(points)))
        length = np.linalg.norm(points[links.row] - points[links.col], axis=1)
        return sp.csr_matrix((length, (links.row, links.col)), shape=links.shape)

    @cached_property
    def _tree(self) -> tuple[KDTree, np.ndarray]:
        front = np.flatnonzero(self.face.on_skin & (self.face.regions["face"] > 0))
        return KDTree(self.mesh.vertices[front]), front

    def nearest(self, points: Float[np.ndarray, "q 3"]) -> Int[np.ndarray, " q"]:
        """The outer skin's vertices next to `points`."""
        tree, front = self._tree
        return front[tree.query(points)[1]]

    def along(self, sources: Int[np.ndarray, " s"]) -> Float[np.ndarray, " n"]:
        """Shortest way along the skin from any of the vertices `sources`, mm; inf where there is none."""
        return dijkstra(self._graph, indices=sources, min_only=True)

    def smooth(self, values: np.ndarray, rounds: int) -> np.ndarray:
        """Averages with neighbours, so many times over."""
        A = sp.csr_matrix(adjacency(self.mesh.faces, len(self.mesh.vertices)) + sp.identity(len(values)))
        A = sp.diags(1.0 / np.asarray(A.sum(axis=1)).ravel()) @ A
        for _ in range(rounds):
            values = A @ values
        return values


def bump(distance: Float[np.ndarray, " n"], width: float) -> Float[np.ndarray, " n"]:
    """1 at distance 0, falling as a bell of standard deviation `width`; 0 where there is no way."""
    return np.exp(-0.5 * (np.nan_to_num(distance, posinf=1e6) / width) ** 2)


def pull_fields(
    where: SkinMap, origin: Float[np.ndarray, " 3"], insertion: Float[np.ndarray, " 3"], pull: Pull
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """What a linear muscle does at full contraction, mm: the draw along the skin, and the belly's rise.

    Skin at the insertion is drawn by `reach` towards the origin, less towards the origin and aside of the fibre. Ways
    are measured along the skin, so that an upper lip's muscle leaves the lower lip alone.
    """
    ends = where.nearest(np.stack([origin, insertion]))
    to_origin, to_insertion = (where.along(ends[i : i + 1]) for i in (0, 1))
    length = to_origin[ends[1]]
    detour = np.nan_to_num(to_origin + to_insertion - length, posinf=1e6)
    past = np.clip(np.nan_to_num(to_origin, posinf=0.0) - length, 0.0, pull.width)
    aside = np.maximum(detour - BEYOND * past, 0.0)
    beside = np.exp(-((aside / pull.width) ** 1.5))
    share = np.clip(np.nan_to_num(to_origin, posinf=1e6) / length, 0.0, 1.0)
    grip = share * share * (3 - 2 * share) * beside
    points, normals = where.mesh.vertices, where.normals
    towards = points[ends[0]] - points
    towards /= np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 0.15 * length)
    towards -= TANGENTIAL * (towards * normals).sum(axis=1, keepdims=True) * normals
    belly = 4 * share * (1 - share) * beside
    drawn = where.smooth(grip[:, None] * towards, 1)
    return pull.reach * drawn, pull.bulge * where.smooth(belly[:, None] * normals, 2)


def lip_fields(where: SkinMap) -> dict[str, Float[np.ndarray, "n 3"]]:
    """What the ring muscle of the mouth and its helpers do at full contraction, by muscle, mm."""
    points, contours = where.mesh.vertices, where.face.contours
    upper, lower = (where.along(contours[f"{side}_lip"][2:-2]) for side in ("upper", "lower"))
    centre = where.landmarks[[13, 14]].mean(axis=0)
    corner = abs(where.landmarks[291, 0] - where.landmarks[61, 0]) / 2
    off = points - centre
    both = np.minimum(upper, lower)
    near, wide, edge = bump(both, 7.0), bump(both, 15.0), {"upper": bump(upper, 5.0), "lower": bump(lower, 5.0)}
    across = np.clip(off[:, 0] / corner, -1.3, 1.3)
    middle = np.clip(1 - across**2, 0, 1)
    rise = np.where(upper <= lower, 1.0, -1.0)
    zero = np.zeros(len(points))
    out = {
        "pucker": wide[:, None] * np.stack([-0.42 * off[:, 0], -0.25 * off[:, 1], 3.0 + 5.0 * middle * near], axis=1),
        "funnel": wide[:, None] * np.stack([-0.22 * off[:, 0], 5.0 * rise * middle, 2.0 + 6.0 * near], axis=1),
        "rollUpper": edge["upper"][:, None] * np.stack([zero, -3.0 * middle, -7.5 * middle], axis=1),
        "rollLower": edge["lower"][:, None] * np.stack([zero, 3.5 * middle, -8.0 * middle], axis=1),
        "shrugUpper": bump(upper, 10.0)[:, None] * np.stack([zero, 4.0 * middle, 4.5 * middle], axis=1),
        "shrugLower": bump(lower, 11.0)[:, None] * np.stack([zero, 7.0 * middle, 4.0 * middle], axis=1),
    }
    for side in SIDES:
        s = SIGN[side]
        half = bump(np.abs(across - 0.45 * s), 0.45)
        out[f"press{side}"] = (near * half)[:, None] * np.stack([1.5 * s + zero, -4.0 * rise, zero - 3.0], axis=1)
        lean = 0.6 + 0.4 * np.clip(s * across, -1, 1)
        aside = np.stack([9.0 * s * lean, 1.0 * s * across, -2.5 * np.clip(s * across, 0, 1)], axis=1)
        out[f"modiolus{side}"] = bump(both, 17.0)[:, None] * aside
    return {name: where.smooth(field_, 1) for name, field_ in out.items()}


def cheek_fields(where: SkinMap) -> dict[str, Float[np.ndarray, "n 3"]]:
    """Cheeks blown up from inside, by side, mm."""
    out = {}
    for side, spot in (("Left", 425), ("Right", 205)):
        middle = where.landmarks[spot] + [SIGN[side] * 6.0, -10.0, 0.0]
        away = where.along(where.nearest(middle[None]))
        out[f"puff{side}"] = where.smooth(8.0 * bump(away, 15.0)[:, None] * where.normals, 2)
    return out


@dataclass(frozen=True)
class Turn:
    """A part that turns about an axis: sin(angle) first + (1 - cos(angle)) second, by Rodrigues' formula."""

    first: Float[np.ndarray, "n 3"]
    second: Float[np.ndarray, "n 3"]


def turn(points: np.ndarray, centre: np.ndarray, axis: np.ndarray, share: Float[np.ndarray, " n"]) -> Turn:
    """`share` of the turn of `points` about `axis` (unit) through `centre`."""
    first = np.cross(axis, points - centre)
    return Turn(share[:, None] * first, share[:, None] * np.cross(axis, first))


def jaw_share(where: SkinMap) -> Float[np.ndarray, " n"]:
    """How much of the jaw's motion each vertex takes, 0 to 1, by the ways along the skin to what moves and what not."""
    points, face = where.mesh.vertices, where.face
    skull = points[:, 1] > where.landmarks[278, 1] + 12.0
    still = np.flatnonzero(where.face.on_skin & (skull | (points[:, 1] < NECK) | (points[:, 2] < NAPE)))
    fixed = np.r_[where.nearest(where.landmarks[list(JAW_FIXED)]), face.contours["upper_lip"][2:-2], still]
    carried = np.r_[where.nearest(where.landmarks[list(JAW_CARRIED)]), face.contours["lower_lip"][2:-2]]
    to_fixed, to_carried = (np.minimum(where.along(np.unique(v)), 1e6) ** 2 for v in (fixed, carried))
    share = where.smooth(np.where(where.face.on_skin, to_fixed / np.maximum(to_fixed + to_carried, 1e-9), 0.0), 4)
    share[face.parts["upper_teeth"]] = 0.0
    share[np.r_[face.parts["lower_teeth"], face.parts["tongue"]]] = 1.0
    for side in ("left_eye", "right_eye"):
        share[face.parts[side]] = 0.0
    return share


def lid_turns(where: SkinMap, ball: Ball, side: str) -> tuple[Turn, Turn, float]:
    """Both lids' turns about the eyeball (upper down, lower up), and the angle between them, radians."""
    points, contours = where.mesh.vertices, where.face.contours
    lids = {level: contours[f"{side.lower()}_{level}_lid"] for level in ("upper", "lower")}
    ways = {level: where.along(line[1:-1]) for level, line in lids.items()}
    corners = points[lids["upper"][[0, -1]]]
    axis = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
    across = 2 * ((points - corners[0]) @ axis) / np.linalg.norm(corners[1] - corners[0]) - 1
    middle = np.clip(1 - across**4, 0, 1) * (points[:, 2] > ball.centre[2])
    turns = []
    for level, sign in (("upper", 1.0), ("lower", -1.0)):
        own, other = ways[level], ways["lower" if level == "upper" else "upper"]
        share = where.smooth(bump(own, 5.5) * middle * (own <= other), 1)
        turns.append(turn(points, ball.centre, sign * axis, np.where(where.face.on_skin, share, 0.0)))
    above, below = (points[line[len(line) // 2]] - ball.centre for line in lids.values())
    return turns[0], turns[1], float(np.arctan2(above[1], above[2]) - np.arctan2(below[1], below[2]))


def tongue_field(where: SkinMap) -> Float[np.ndarray, "n 3"]:
    """The tongue out, its root held."""
    rows, out = where.face.parts["tongue"], np.zeros_like(where.mesh.vertices)
    z = where.mesh.vertices[rows, 2]
    out[rows] = np.clip((z - z.min()) / np.ptp(z), 0, 1)[:, None] ** 0.5 * [0.0, 2.0, 38.0]
    return out
