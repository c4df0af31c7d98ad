"""Where markers are glued: well spread, closer together round mouth and brows, never on lid margins or in the lips."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...faces.bundled import load_face
from ...mesh import Attachment, ClosestPoint, face_areas, vertex_normals
from ..people.performer import Performer
from ..people.skin import Skin

SIZES = (16, 30, 50, 100, 200)
"""Usual layouts; any number from 6 to 400 can be had."""
CANDIDATES = 9000
"""Random points on the skin that a layout is chosen from."""
PAIRED = (
    "browInnerUp", "browOuterUpLeft", "mouthSmileLeft", "cheekSquintLeft", "mouthUpperUpLeft", "mouthLowerDownLeft"
)  # fmt: skip
"""Every layout has a pair where each of these moves the skin most; on the middle: chin, nose, forehead, nasion."""


@dataclass(frozen=True)
class MarkerLayout:
    """Markers on a performer's skin."""

    attachment: Attachment
    """On the actor's mesh: the bundled topology, or a `Skin`'s own."""
    labels: tuple[str, ...]
    """`M000` and so on, from the forehead down: they say nothing about places."""


def marker_layout(actor: Performer | Skin, count: int, seed: int = 0) -> MarkerLayout:
    """`count` markers in mirrored pairs, glued by hand: some millimetres off symmetry.

    Farthest-point sampling of random points on the face, distances stretched where the face moves most. On a `Skin`
    they are glued to its fine surface.

    Raises:
        BadInput: count outside 6..400.
    """
    if not 6 <= count <= 400:
        raise BadInput(f"count: expected 6 to 400 markers, got {count}")
    rng, performer = np.random.default_rng([seed, 6]), actor.performer if isinstance(actor, Skin) else actor
    points, crowding, motion = _candidates(performer, rng)
    first = _anchors(performer, points, motion)
    glued = _farthest(points, crowding, first, count) + rng.normal(size=(count, 3)) * min(1.0, 8.0 / np.sqrt(count))
    order = np.argsort(-glued[:, 1])
    found = ClosestPoint(actor.neutral).query(glued[order])
    return MarkerLayout(found.attachment(), tuple(f"M{i:03d}" for i in range(count)))


def _candidates(performer: Performer, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on the left half and the middle of the face, how closely markers should sit there (1 is usual), and
    how far each unit moves them (points, shapes)."""
    mesh, allowed = performer.neutral, _allowed(performer)
    keep = np.flatnonzero((allowed[mesh.faces] > 0.5).all(axis=1))
    area = face_areas(mesh.vertices, mesh.faces)[keep]
    picked = keep[rng.choice(len(keep), CANDIDATES, p=area / area.sum())]
    bary = rng.dirichlet(np.ones(3), CANDIDATES)
    points = np.einsum("pc,pcd->pd", bary, mesh.vertices[mesh.faces[picked]])
    crowd = np.einsum("pc,pc->p", bary, _crowding(performer)[mesh.faces[picked]])
    size = np.linalg.norm(performer.units, axis=2).T
    motion = np.einsum("pc,pck->pk", bary, size[mesh.faces[picked]])
    middle = np.abs(points[:, 0]) < 1.0
    points[middle, 0] = 0.0
    used = middle | (points[:, 0] > 4.0)
    return points[used], crowd[used], motion[used]


def _anchors(performer: Performer, points: np.ndarray, motion: np.ndarray) -> list[int]:
    """Candidates that every layout starts from, most telling first."""
    side, middle = points[:, 0] > 0, points[:, 0] == 0
    pairs = [int(np.argmax(motion[:, performer.names.index(name)] * side)) for name in PAIRED]
    eyes = (performer.eyes["Left"].centre + performer.eyes["Right"].centre) / 2
    chin = int(np.argmax(motion[:, performer.names.index("jawOpen")] * middle))
    nose = int(np.argmax(np.where(middle, points[:, 2], -np.inf)))
    forehead = int(np.argmax(np.where(middle, -np.abs(points[:, 1] - eyes[1] - 55), -np.inf)))
    nasion = int(np.argmax(np.where(middle, -np.abs(points[:, 1] - eyes[1]), -np.inf)))
    return [chin, nose, *pairs[:3], forehead, nasion, *pairs[3:]]


def _allowed(performer: Performer) -> Float[np.ndarray, " n"]:
    """Where a marker may sit: the front of the face, off the lids, the red of the lips inside, and the nostrils."""
    vertices = performer.neutral.vertices
    region = load_face().regions["face"].copy()
    for side, ball in performer.eyes.items():
        region[_near(vertices, np.concatenate(performer.lids[side].points(vertices)), 5.0)] = 0
        region[np.linalg.norm(vertices - ball.centre, axis=1) < ball.radius + 2.0] = 0
    region[_near(vertices, np.concatenate(performer.lips.points(vertices)), 4.0)] = 0
    normals = vertex_normals(vertices, performer.neutral.faces)
    region[(normals[:, 2] < -0.1) | (normals[:, 1] < -0.85)] = 0
    return region


def _near(vertices: np.ndarray, points: np.ndarray, reach: float) -> np.ndarray:
    return (np.linalg.norm(vertices[:, None] - points[None], axis=2) < reach).any(axis=1)


def _crowding(performer: Performer) -> Float[np.ndarray, " n"]:
    """1 on forehead and outer cheek, up to 2 where units move the skin most: round mouth and brows."""
    busy = np.sqrt((performer.units**2).sum(axis=(0, 2)))
    return 1.0 + 1.0 * np.clip(busy / np.percentile(busy, 92), 0, 1)


def _farthest(points: np.ndarray, crowding: np.ndarray, first: list[int], count: int) -> Float[np.ndarray, "count 3"]:
    """The points `first`, then greedy farthest ones; each off the middle brings its mirror image."""
    chosen: list[np.ndarray] = []
    middle = points[:, 0] == 0
    distance = np.full(len(points), 1e3)
    queue = list(first)
    while len(chosen) < count:
        alone = count - len(chosen) == 1
        usable = np.where(middle | (not alone), distance * crowding, -1.0)
        i = queue.pop(0) if queue and not alone else int(np.argmax(usable))
        if distance[i] < 1.0:
            continue
        own = points[i]
        for p in [own] if middle[i] else [own, own * [-1, 1, 1]]:
            distance = np.minimum(distance, np.linalg.norm(points - p, axis=1))
            chosen.append(p)
    return np.stack(chosen)
