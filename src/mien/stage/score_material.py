"""Errors of results in a topology of their own: where is the skin that each vertex covered at rest?"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mesh import Attachment, Mesh, closest_point
from ..transforms import Transform
from .people.performer import Performer
from .people.skin import Skin
from .sensors.scanner import StagedScan
from .truth import Truth

CHUNK = 100
"""Frames of truth that are worked out at once."""


def material_under(
    actor: Skin | Performer, vertices: Float[np.ndarray, "n 3"], points: Float[np.ndarray, "p 3"]
) -> tuple[Attachment, Float[np.ndarray, " p"]]:
    """The points of the actor's skin, now at `vertices`, that are closest to `points`, and the distances, mm."""
    faces = np.flatnonzero(actor.skin[actor.neutral.faces].all(axis=1))
    found = closest_point(Mesh(vertices, actor.neutral.faces[faces]), points)
    return Attachment(faces[found.faces], found.barycentric), found.distances


def scan_errors(
    shapes: Sequence[Float[np.ndarray, "n 3"]], T_face_scan: Sequence[Transform], scans: Sequence[StagedScan]
) -> Float[np.ndarray, "scans n"]:
    """How far each vertex of registered scans is from the skin that it covers on the first one, mm.

    Args:
        shapes: the scans in one topology, face space, mm.
        T_face_scan: rigid, as found.
    """
    actor = scans[0].truth.actor
    true = [T.apply(staged.truth.vertices) for T, staged in zip(T_face_scan, scans, strict=True)]
    material, _ = material_under(actor, true[0], shapes[0])
    places = [material.points(actor.neutral.with_vertices(x)) for x in true]
    return np.stack([np.linalg.norm(x - place, axis=1) for x, place in zip(shapes, places, strict=True)])


@dataclass(frozen=True)
class MaterialScore:
    """Errors of a performance against the truth, mm, over sampled frames."""

    frames: Int[np.ndarray, " f"]
    errors: Float[np.ndarray, "f p"]
    """Distance of each scored vertex, placed in the lab, from the skin that it covers at rest."""
    frozen: Float[np.ndarray, "f p"]
    """The same for the right person in the right pose with the take's mean expression."""
    share: Float[np.ndarray, " p"]
    """Of the surface, of each scored vertex: all means are over the surface, however its vertices are spread."""
    strength: Float[np.ndarray, " f"]
    """How far the true skin is from its neutral."""

    @property
    def error(self) -> Float[np.ndarray, " f"]:
        """Mean error of each frame, mm."""
        return self.errors @ self.share

    @property
    def baseline(self) -> Float[np.ndarray, " f"]:
        """Mean error of each frame of the frozen face, mm."""
        return self.frozen @ self.share

    @property
    def strongest(self) -> Bool[np.ndarray, " f"]:
        """The tenth of the frames with the strongest true expression."""
        mask = np.zeros(len(self.frames), bool)
        mask[np.argsort(-self.strength, kind="stable")[: max(1, round(len(self.frames) / 10))]] = True
        return mask

    @property
    def ratio(self) -> float:
        """Error over the frozen one, the take's means."""
        return float(self.error.mean() / self.baseline.mean())

    @property
    def ratio_strongest(self) -> float:
        """The same over the strongest tenth."""
        return float(self.error[self.strongest].mean() / self.baseline[self.strongest].mean())

    def rows(self) -> list[tuple[str, str, str, str]]:
        """(what, error, frozen baseline, ratio), ready to print."""
        s, error, frozen = self.strongest, self.error, self.baseline
        return [
            ("full mesh, take", f"{error.mean():.3f} mm", f"{frozen.mean():.3f} mm", f"{self.ratio:.0%}"),
            ("full mesh, strongest tenth", f"{error[s].mean():.3f} mm", f"{frozen[s].mean():.3f} mm",
             f"{self.ratio_strongest:.0%}"),
        ]  # fmt: skip


def score_material(
    vertices: Callable[[int], Float[np.ndarray, "p 3"]],
    T_lab_face: Transform,
    truth: Truth,
    rest: int,
    frames: Int[np.ndarray, " f"],
    areas: Float[np.ndarray, " p"],
) -> MaterialScore:
    """Score any mesh, whatever its topology: labels are its own, taken from the frame at rest.

    Args:
        vertices: frame -> the scored vertices in the result's face space, mm.
        T_lab_face: the result's head pose, a frame each, in the lab of the truth.
        rest: the frame in which vertices are matched with skin.
        areas: of the scored vertices, mm^2.
    """
    actor = truth.actor
    at_rest = truth.T_lab_face[rest].inverse().apply(T_lab_face[rest].apply(vertices(rest)))
    material, _ = material_under(actor, actor.vertices(truth.weights[[rest]])[0], at_rest)
    corners = actor.neutral.faces[material.faces]
    rows, local = np.unique(corners, return_inverse=True)
    local = local.reshape(corners.shape)

    def skin(v: np.ndarray) -> np.ndarray:
        return np.einsum("pc,...pcd->...pd", material.barycentric, v[..., local, :])

    neutral = skin(actor.neutral.vertices[rows])
    errors, moved = [], []
    for part in np.array_split(frames, max(1, len(frames) // CHUNK)):
        true = skin(actor.vertices(truth.weights[part], rows))
        placed = np.stack([T_lab_face[t].apply(vertices(int(t))) for t in part])
        errors.append(np.linalg.norm(truth.T_lab_face[part].inverse().apply(placed) - true, axis=2))
        moved.append((true - neutral).astype(np.float32))
    motion = np.concatenate(moved)
    frozen = np.linalg.norm(motion - motion.mean(axis=0), axis=2)
    share = areas / areas.sum()
    return MaterialScore(
        frames, np.concatenate(errors), frozen.astype(np.float64), share, np.linalg.norm(motion, axis=2) @ share
    )
