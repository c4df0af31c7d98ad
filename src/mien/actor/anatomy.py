"""What a face is made of where blendshapes alone go wrong: a hinged jaw, lids on a ball, lips that touch."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree

from ..mesh import Mesh, closest_point, submesh, vertex_normals
from ..rig import Rig

LID_SHELL = (0.4, 4.5)
"""Skin between these heights over the eyeball (mm) belongs to the lids that can touch."""
LID_REACH = 1.6
"""Lid points nearer than this in the generic blink are partners (mm)."""
LIP_REACH = 3.5
"""Lip points nearer than this in the generic neutral face are partners (mm)."""


@dataclass(frozen=True)
class Ball:
    """An eyeball."""

    centre: Float[np.ndarray, " 3"]
    radius: float
    vertices: Int[np.ndarray, " v"]


@dataclass(frozen=True)
class Contact:
    """Pairs of points that meet when a lid or a mouth closes, and how the skin follows when they are pushed."""

    vertices: Int[np.ndarray, " m"]
    """The vertices that take part; the matrices speak of these alone."""
    upper: sp.csr_matrix
    """(pairs, m): rows give the upper partner's position."""
    lower: sp.csr_matrix
    spread_upper: sp.csr_matrix
    """(m, pairs): the motion of every vertex when the upper partners are moved."""
    spread_lower: sp.csr_matrix
    offset: Float[np.ndarray, "pairs 3"]
    """Upper minus lower partner when they touch, mm."""
    normal: Float[np.ndarray, "pairs 3"]
    """Unit vector out of the lower partner, into the upper one."""


    def points(self, vertices: Float[np.ndarray, "n 3"]) -> tuple[np.ndarray, np.ndarray]:
        """Upper and lower partners (pairs, 3) on a whole face."""
        own = vertices[self.vertices]
        return self.upper @ own, self.lower @ own


@dataclass(frozen=True)
class Hinge:
    """The jaw's axis, parallel to x."""

    centre: Float[np.ndarray, " 3"]
    angle: float
    """How far the generic jaw turns at full opening, radians, positive downwards."""


def eyeball(rig: Rig, vertices: Int[np.ndarray, " v"]) -> Ball:
    """The ball through the vertices of an eye."""
    points = rig.neutral.vertices[vertices]
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return Ball(centre, float(np.linalg.norm(points - centre, axis=1).max()), vertices)


def jaw_hinge(rig: Rig, lower_teeth: Int[np.ndarray, " v"]) -> Hinge:
    """Axis and angle of the rigid motion that `jawOpen` gives the lower teeth."""
    closed = rig.neutral.vertices[lower_teeth]
    R, t = rigid_motion(closed, closed + rig.deltas[rig.index("jawOpen")][lower_teeth])
    yz = np.linalg.lstsq((np.eye(3) - R)[1:, 1:], t[1:], rcond=None)[0]
    return Hinge(np.array([0.0, *yz]), float(np.arctan2(R[2, 1], R[1, 1])))


def rigid_motion(
    source: Float[np.ndarray, "*batch v 3"], target: Float[np.ndarray, "*batch v 3"]
) -> tuple[Float[np.ndarray, "*batch 3 3"], Float[np.ndarray, "*batch 3"]]:
    """Least-squares rotation and translation source -> target, batched over leading axes (Kabsch 1976)."""
    a, b = source.mean(axis=-2), target.mean(axis=-2)
    H = np.swapaxes(target - b[..., None, :], -1, -2) @ (source - a[..., None, :])
    U, _, Vt = np.linalg.svd(H)
    U[..., :, 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    R = U @ Vt
    return R, b - (R @ a[..., None])[..., 0]


def lid_contact(rig: Rig, ball: Ball, side: str, skin: Bool[np.ndarray, " n"]) -> Contact:
    """Partners on the two lids of one eye (`side` "Left" or "Right"), found in the generic blink."""
    vertices, blink = rig.neutral.vertices, rig.deltas[rig.index(f"eyeBlink{side}")]
    height = np.linalg.norm(vertices - ball.centre, axis=1) - ball.radius
    shell = skin & (height > LID_SHELL[0]) & (height < LID_SHELL[1]) & (vertices[:, 2] > ball.centre[2])
    reach = np.linalg.norm(blink, axis=1)
    upper, lower = np.flatnonzero(shell & (blink[:, 1] < -2.0)), np.flatnonzero(shell & (reach < 1.5))
    closed = vertices + blink
    distance, nearest = KDTree(closed[lower]).query(closed[upper])
    near = distance < LID_REACH
    upper, lower = upper[near], lower[nearest[near]]
    n, pairs = len(vertices), np.arange(len(upper))
    one = np.ones(len(upper))
    spread = _shepard(vertices, vertices[upper], sigma=2.5)
    follow = np.minimum(reach[:, None] / reach[upper][None, :], 1.0) * skin[:, None]
    away = _unit(closed[upper] - vertices[upper])
    return _compact(
        upper=sp.csr_matrix((one, (pairs, upper)), (len(upper), n)),
        lower=sp.csr_matrix((one, (pairs, lower)), (len(upper), n)),
        spread_upper=sp.csr_matrix(spread * follow),
        spread_lower=sp.csr_matrix((n, len(upper))),
        offset=closed[upper] - closed[lower],
        normal=-away,
    )


def lip_contact(rig: Rig, skin: Bool[np.ndarray, " n"]) -> Contact:
    """Partners on the two lips, found in the generic neutral face by what the jaw moves and what it leaves."""
    mesh, jaw = rig.neutral, rig.deltas[rig.index("jawOpen")]
    normals = vertex_normals(mesh.vertices, mesh.faces)
    funnel = np.linalg.norm(rig.deltas[rig.index("mouthFunnel")], axis=1) * skin
    mouth = mesh.vertices[funnel == funnel.max()][0]
    zone = skin & (np.abs(mesh.vertices - [0, mouth[1], mouth[2]]) < [26, 14, 14]).all(axis=1)
    middle = zone & (np.abs(mesh.vertices[:, 0]) < 2)
    split = np.abs(jaw[middle, 1]).max() * 0.45
    fall = -jaw[:, 1] + split * np.clip(np.abs(mesh.vertices[:, 0]) / 26, 0, 1) * 0.35
    below, above = zone & (fall > split), zone & (fall < split)
    facing_up = np.flatnonzero(below & (normals[:, 1] > 0.5))
    facing_down = np.flatnonzero(above & (normals[:, 1] < -0.5))
    up_a, lo_a = _partners(mesh, facing_down, below)
    lo_b, up_b = _partners(mesh, facing_up, above)
    upper, lower = sp.vstack([up_a, up_b]).tocsr(), sp.vstack([lo_a, lo_b]).tocsr()
    normal = _unit(lower @ normals - upper @ normals)
    upright = normal[:, 1] > 0.5
    upper, lower, normal = upper[upright], lower[upright], normal[upright]
    fall_upper, fall_lower = -(upper @ jaw)[:, 1], -(lower @ jaw)[:, 1]
    points = (upper @ mesh.vertices + lower @ mesh.vertices) / 2
    spread = _shepard(mesh.vertices, points, sigma=4.0) * skin[:, None]
    share = np.clip((-jaw[:, 1][:, None] - fall_upper) / np.maximum(fall_lower - fall_upper, 1.0), 0, 1)
    return _compact(
        upper=upper,
        lower=lower,
        spread_upper=sp.csr_matrix(spread * (1 - share)),
        spread_lower=sp.csr_matrix(spread * share),
        offset=np.zeros((len(points), 3)),
        normal=normal,
    )


def _compact(
    upper: sp.csr_matrix, lower: sp.csr_matrix, spread_upper: sp.csr_matrix, spread_lower: sp.csr_matrix,
    offset: np.ndarray, normal: np.ndarray,
) -> Contact:
    """Matrices over all vertices -> a contact over those that take part."""
    used = [abs(upper).sum(axis=0), abs(lower).sum(axis=0), spread_upper.sum(axis=1).T, spread_lower.sum(axis=1).T]
    m = np.flatnonzero(sum(np.asarray(u).ravel() for u in used))
    return Contact(m, upper[:, m], lower[:, m], spread_upper[m], spread_lower[m], offset, normal)


def _partners(mesh: Mesh, ours: Int[np.ndarray, " q"], theirs: Bool[np.ndarray, " n"]):
    """Rows (vertex of ours, nearest point on the surface of theirs) where the two are within reach."""
    other, old = submesh(mesh, np.flatnonzero(theirs[mesh.faces].all(axis=1)))
    found = closest_point(other, mesh.vertices[ours])
    near = found.distances < LIP_REACH
    rows, n = np.arange(near.sum()), len(mesh.vertices)
    own = sp.csr_matrix((np.ones(near.sum()), (rows, ours[near])), (len(rows), n))
    columns = old[other.faces[found.faces[near]]].ravel()
    partner = sp.csr_matrix((found.barycentric[near].ravel(), (np.repeat(rows, 3), columns)), (len(rows), n))
    return own, partner


def _shepard(vertices: np.ndarray, points: np.ndarray, sigma: float) -> np.ndarray:
    """Weights (n, p) that carry values at points to vertices: averages nearby, fading with distance."""
    squared = ((vertices[:, None] - points[None]) ** 2).sum(axis=2)
    weights = np.exp(-squared / (2 * sigma**2))
    weights[weights < 1e-3] = 0.0
    return weights / np.maximum(weights.sum(axis=1, keepdims=True), 1.0)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length == 0, 1.0, length)
