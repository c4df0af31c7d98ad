"""What a face is made of where blendshapes alone go wrong: a hinged jaw, lids on a ball, lips that touch."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int

from ...faces.bundled import BundledFace
from ...mesh import vertex_normals
from ...rig import Rig

LID_OVERLAP = (0.4, 0.8)
"""How far a closed upper lid comes over the lower one, least and most, mm."""


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
    follow_upper: sp.csr_matrix
    """(m, pairs): the motion of every vertex when the upper partners are moved."""
    follow_lower: sp.csr_matrix
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


def eyeball(face: BundledFace, vertices: Float[np.ndarray, "n 3"], side: str) -> Ball:
    """The ball of one eye (`side` "Left" or "Right") of a face in this topology."""
    centre, radius = face.eyeball(vertices, side.lower())
    return Ball(centre, radius, face.parts[f"{side.lower()}_eye"])


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


def lid_contact(face: BundledFace, ball: Ball, side: str, skin: Bool[np.ndarray, " n"]) -> Contact:
    """The edges of one eye's lids (`side` "Left" or "Right"); partners are above one another in the generic blink.

    Closed, the upper edge lies a little below the lower one, `LID_OVERLAP` mm, whatever the generic blink leaves.
    """
    vertices, blink = face.rig.neutral.vertices, face.rig.deltas[face.rig.index(f"eyeBlink{side}")]
    upper = face.contours[f"{side.lower()}_upper_lid"][1:-1]
    closed = vertices + blink
    across = np.array([1.0, 0.0, 0.0])
    lower = _on_line(closed * across, closed[upper] * across, face.contours[f"{side.lower()}_lower_lid"])
    offset = closed[upper] - lower @ closed
    offset[:, 1] = np.clip(offset[:, 1], -LID_OVERLAP[1], -LID_OVERLAP[0])
    reach = np.linalg.norm(blink, axis=1)
    follow = np.minimum((reach[:, None] + 0.5) / (reach[upper] + 0.5)[None, :], 1.0) * skin[:, None]
    front = vertices[:, 2] > ball.centre[2] - 0.5 * ball.radius
    above = _nearer(vertices, upper, face.contours[f"{side.lower()}_lower_lid"])
    spread = _shepard(vertices, vertices[upper], sigma=3.0) * (front * above)[:, None] * follow
    return _compact(
        upper=_rows_of(upper, len(vertices)),
        lower=lower,
        follow_upper=sp.csr_matrix(np.where(np.abs(spread) > 1e-4, spread, 0.0)),
        follow_lower=sp.csr_matrix((len(vertices), len(upper))),
        offset=offset,
        normal=_unit(vertices[upper] - closed[upper]),
    )


def lip_contact(face: BundledFace, skin: Bool[np.ndarray, " n"]) -> Contact:
    """The edges of the lips; each vertex's partner is the nearest point of the other edge in the neutral face."""
    vertices, jaw = face.rig.neutral.vertices, face.rig.deltas[face.rig.index("jawOpen")]
    line_upper, line_lower = (face.contours[name][1:-1] for name in ("upper_lip", "lower_lip"))
    n = len(vertices)
    upper = _stack(_rows_of(line_upper, n), _on_line(vertices, vertices[line_lower], line_upper))
    lower = _stack(_on_line(vertices, vertices[line_upper], line_lower), _rows_of(line_lower, n))
    normals = vertex_normals(vertices, face.rig.neutral.faces)
    fall_upper, fall_lower = -(upper @ jaw)[:, 1], -(lower @ jaw)[:, 1]
    points = (upper @ vertices + lower @ vertices) / 2
    spread = _shepard(vertices, points, sigma=4.0) * skin[:, None]
    share = np.clip((-jaw[:, 1][:, None] - fall_upper) / np.maximum(fall_lower - fall_upper, 1.0), 0, 1)
    return _compact(
        upper=upper,
        lower=lower,
        follow_upper=sp.csr_matrix(spread * (1 - share)),
        follow_lower=sp.csr_matrix(spread * share),
        offset=np.zeros((len(points), 3)),
        normal=_unit((lower @ normals - upper @ normals) * [0.3, 1.0, 0.3]),
    )


def _stack(first: sp.csr_matrix, second: sp.csr_matrix) -> sp.csr_matrix:
    return sp.csr_matrix(sp.vstack([first, second]))


def _nearer(vertices: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> Float[np.ndarray, " n"]:
    """1 on our line, 0 on theirs, smooth between: whose lid each vertex belongs to."""
    own, other = (np.linalg.norm(vertices[:, None] - vertices[line], axis=2).min(axis=1) for line in (ours, theirs))
    return other**2 / np.maximum(own**2 + other**2, 1e-12)


def _rows_of(vertices: Int[np.ndarray, " q"], n: int) -> sp.csr_matrix:
    """Rows that pick single vertices."""
    return sp.csr_matrix((np.ones(len(vertices)), (np.arange(len(vertices)), vertices)), (len(vertices), n))


def _on_line(
    vertices: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "q 3"], line: Int[np.ndarray, " k"]
) -> sp.csr_matrix:
    """Rows that give the nearest point of the polyline through the vertices `line` to each of `points`."""
    a, b = vertices[line[:-1]], vertices[line[1:]]
    along = ((points[:, None] - a) * (b - a)).sum(axis=2) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-12)
    along = np.clip(along, 0, 1)
    distance = np.linalg.norm(points[:, None] - a - along[..., None] * (b - a), axis=2)
    segment, rows = distance.argmin(axis=1), np.arange(len(points))
    t = along[rows, segment]
    entries, columns = np.concatenate([1 - t, t]), np.concatenate([line[segment], line[segment + 1]])
    return sp.csr_matrix((entries, (np.tile(rows, 2), columns)), (len(points), len(vertices)))


def _compact(
    upper: sp.csr_matrix, lower: sp.csr_matrix, follow_upper: sp.csr_matrix, follow_lower: sp.csr_matrix,
    offset: np.ndarray, normal: np.ndarray,
) -> Contact:
    """Matrices over all vertices -> a contact over those that take part."""
    used = [abs(m).sum(axis=axis).ravel() for m, axis in ((upper, 0), (lower, 0), (follow_upper, 1), (follow_lower, 1))]
    m = np.flatnonzero(sum(np.asarray(u).ravel() for u in used))
    return Contact(m, upper[:, m], lower[:, m], follow_upper[m], follow_lower[m], offset, normal)


def _shepard(vertices: np.ndarray, points: np.ndarray, sigma: float) -> np.ndarray:
    """Weights (n, p) that carry values at points to vertices: averages nearby, fading with distance."""
    squared = ((vertices[:, None] - points[None]) ** 2).sum(axis=2)
    weights = np.exp(-squared / (2 * sigma**2))
    weights[weights < 1e-3] = 0.0
    return weights / np.maximum(weights.sum(axis=1, keepdims=True), 1.0)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length == 0, 1.0, length)
