"""How far a result is from the truth, in millimetres, always beside what a frozen face would score."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..faces.bundled import load_face
from ..mesh import ClosestPoint, Mesh, submesh
from ..rig import Performance
from ..transforms import Transform
from .people.performer import CHUNK
from .truth import Truth

Vertices = Callable[[Int[np.ndarray, " f"]], Float[np.ndarray, "f n 3"]]
"""Frame numbers -> a result's vertices in its own face space, mm, in the bundled topology."""


@dataclass(frozen=True)
class Score:
    """Errors of a result against the truth. v runs over the region's vertices, t over the scored frames.

    True vertices V_t and neutral V_0 in the truth's face space, T_t the true pose; result S_t, S_0 and pose U_t.
    """

    frames: Int[np.ndarray, " f"]
    """The frames scored."""
    absolute: Float[np.ndarray, " f"]
    """mean_v |U_t S_t - T_t V_t|: vertex to its true place in the world, mm."""
    absolute_p95: float
    """95th percentile of the same over all v and t, mm."""
    surface: float
    """Mean over v and some 24 of the frames: distance from the result's vertex to the true surface, mm."""
    surface_p95: float
    """95th percentile of the same, mm."""
    expression: Float[np.ndarray, " f"]
    """mean_v |R_t (S_t - S_0) - (V_t - V_0)|, R_t turning result to truth by the difference of the two poses, mm."""
    frozen: Float[np.ndarray, " f"]
    """mean_v |E - (V_t - V_0)|, E the mean over t of V_t - V_0: the right person in the right pose with one fixed face.
    Its absolute error is the same number."""
    strength: Float[np.ndarray, " f"]
    """mean_v |V_t - V_0|: how strong the true expression is, mm."""
    rotation: Float[np.ndarray, " f"]
    """Angle between the two poses beyond a constant one (two face spaces may differ), radians."""

    @property
    def strongest(self) -> Bool[np.ndarray, " f"]:
        """The tenth of the frames with the strongest true expression."""
        count = max(1, round(len(self.frames) / 10))
        mask = np.zeros(len(self.frames), dtype=bool)
        mask[np.argsort(-self.strength, kind="stable")[:count]] = True
        return mask

    @property
    def ratio(self) -> float:
        """Expression error over the frozen one, the take's means. 1: no better than a frozen face."""
        return _ratio(self.expression.mean(), self.frozen.mean())

    @property
    def ratio_strongest(self) -> float:
        """The same over the strongest tenth."""
        return _ratio(self.expression[self.strongest].mean(), self.frozen[self.strongest].mean())

    def rows(self) -> list[tuple[str, str, str, str]]:
        """(what, error, frozen baseline, ratio), ready to print."""
        s = self.strongest
        return [
            ("vertices, mean", _mm(self.absolute.mean()), _mm(self.frozen.mean()),
             _percent(_ratio(self.absolute.mean(), self.frozen.mean()))),
            ("vertices, 95 %", _mm(self.absolute_p95), "", ""),
            ("surface, mean", _mm(self.surface), "", ""),
            ("surface, 95 %", _mm(self.surface_p95), "", ""),
            ("expression, take", _mm(self.expression.mean()), _mm(self.frozen.mean()), _percent(self.ratio)),
            ("expression, strongest tenth", _mm(self.expression[s].mean()), _mm(self.frozen[s].mean()),
             _percent(self.ratio_strongest)),
        ]  # fmt: skip

    def to_dict(self) -> dict[str, float]:
        """The figures alone, mm and ratios."""
        s = self.strongest
        return {
            "absolute_mm": float(self.absolute.mean()),
            "absolute_p95_mm": self.absolute_p95,
            "surface_mm": self.surface,
            "surface_p95_mm": self.surface_p95,
            "frozen_mm": float(self.frozen.mean()),
            "expression_mm": float(self.expression.mean()),
            "expression_ratio": self.ratio,
            "strongest_expression_mm": float(self.expression[s].mean()),
            "strongest_frozen_mm": float(self.frozen[s].mean()),
            "strongest_ratio": self.ratio_strongest,
        }


def score_performance(
    performance: Performance,
    truth: Truth,
    region: Float[np.ndarray, " n"] | None = None,
    step: int = 1,
) -> Score:
    """Score a performance whose rig has the bundled topology, vertex by vertex. Untracked frames count as they are.

    Args:
        region: vertices above 0.5 are scored; the bundled face's `face` by default.
        step: every so many frames.

    Raises:
        BadInput: another number of frames or vertices than the truth has.
    """
    if len(performance) != len(truth):
        raise BadInput(f"performance: expected {len(truth)} frames, as the truth has, got {len(performance)}")
    return score_vertices(
        vertices=lambda frames: performance.rig.vertices(performance.weights[frames]),
        neutral=performance.rig.neutral.vertices,
        T_world_face=performance.T_world_face,
        truth=truth,
        region=region,
        frames=np.arange(0, len(truth), step),
    )


def score_vertices(
    vertices: Vertices,
    neutral: Float[np.ndarray, "n 3"],
    T_world_face: Transform,
    truth: Truth,
    region: Float[np.ndarray, " n"] | None = None,
    frames: Int[np.ndarray, " f"] | None = None,
) -> Score:
    """Score anything that gives vertices in the bundled topology: correctives, trackers, meshes of another rig.

    The result's world may be the lab turned by quarter turns (to +Y up): the turn that fits best is undone.

    Raises:
        BadInput: a neutral with another number of vertices than the truth's.
    """
    if neutral.shape != truth.neutral.vertices.shape:
        raise BadInput(f"neutral: expected {truth.neutral.vertices.shape}, the truth's vertices, got {neutral.shape}")
    frames = np.arange(len(truth)) if frames is None else frames
    mask = (load_face().regions["face"] if region is None else region) > 0.5
    turn = _quarter_turn(T_world_face[frames], truth.T_lab_face[frames], neutral, truth)
    T_lab_result = Transform(turn @ T_world_face.rotation, T_world_face.translation @ turn.T)
    mean, strength = _mean_expression(truth, frames, mask)
    R_truth_result = np.swapaxes(truth.T_lab_face.rotation, 1, 2) @ T_lab_result.rotation
    absolute, expression, frozen, samples = [], [], [], []
    rest, true_rest = neutral[mask], truth.neutral.vertices[mask]
    for some, V in truth.stream(frames):
        S, true = vertices(some)[:, mask], V[:, mask]
        distance = np.linalg.norm(T_lab_result[some].apply(S) - truth.T_lab_face[some].apply(true), axis=2)
        turned = (S - rest) @ np.swapaxes(R_truth_result[some], 1, 2)
        absolute.append(distance.mean(axis=1))
        expression.append(np.linalg.norm(turned - (true - true_rest), axis=2).mean(axis=1))
        frozen.append(np.linalg.norm(mean - (true - true_rest), axis=2).mean(axis=1))
        samples.append(distance.astype(np.float32).ravel())
    surface = _surface(vertices, T_lab_result, truth, frames[:: max(1, len(frames) // 24)], mask)
    return Score(
        frames=frames,
        absolute=np.concatenate(absolute),
        absolute_p95=float(np.percentile(np.concatenate(samples), 95)),
        surface=float(surface.mean()),
        surface_p95=float(np.percentile(surface, 95)),
        expression=np.concatenate(expression),
        frozen=np.concatenate(frozen),
        strength=strength,
        rotation=_beyond_constant(R_truth_result[frames]),
    )


def _mean_expression(truth: Truth, frames: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """E (v, 3) and the strength of every frame."""
    total, strength = np.zeros((mask.sum(), 3)), []
    for _, V in truth.stream(frames, CHUNK):
        moved = (V - truth.neutral.vertices)[:, mask]
        total += moved.sum(axis=0)
        strength.append(np.linalg.norm(moved, axis=2).mean(axis=1))
    return total / len(frames), np.concatenate(strength)


def _surface(
    vertices: Vertices, T_lab_result: Transform, truth: Truth, frames: np.ndarray, mask: np.ndarray
) -> np.ndarray:
    """Distances (f, v) from the result's vertices to the true skin, mm."""
    actor = truth.actor
    skin, old = submesh(actor.neutral, np.flatnonzero(actor.skin[actor.neutral.faces].all(axis=1)))
    T_truth_result = truth.T_lab_face[frames].inverse() @ T_lab_result[frames]
    found = []
    for i, S in enumerate(vertices(frames)):
        true = ClosestPoint(Mesh(actor.vertices(truth.weights[frames[i : i + 1]])[0][old], skin.faces))
        found.append(true.query(T_truth_result[i].apply(S[mask])).distances)
    return np.stack(found)


def _quarter_turn(T_world_face: Transform, T_lab_face: Transform, neutral: np.ndarray, truth: Truth) -> np.ndarray:
    """The turn world -> lab by quarter turns that brings the result's head nearest to the true one."""
    some = np.unique(np.linspace(0, len(T_world_face) - 1, 32).astype(int))
    sample = np.stack([neutral[::50], truth.neutral.vertices[::50]])
    points, true = (np.broadcast_to(s, (len(some), *s.shape)) for s in sample)
    placed, target = T_world_face[some].apply(points), T_lab_face[some].apply(true)
    turns = [np.eye(3)[list(p)] * s for p in permutations(range(3)) for s in product((1, -1), repeat=3)]
    turns = [R for R in turns if np.linalg.det(R) > 0]
    errors = [np.linalg.norm(placed @ R.T - target, axis=2).mean() for R in turns]
    return turns[int(np.argmin(errors))]


def _beyond_constant(R: Float[np.ndarray, "f 3 3"]) -> Float[np.ndarray, " f"]:
    U, _, Vt = np.linalg.svd(R.mean(axis=0))
    cosine = (np.einsum("fij,ij->f", R, U @ Vt) - 1) / 2
    return np.arccos(np.clip(cosine, -1, 1))


def _ratio(error: float, frozen: float) -> float:
    return float(error / frozen) if frozen > 0 else float("nan")


def _mm(value: float) -> str:
    return f"{value:.3f} mm"


def _percent(value: float) -> str:
    return f"{100 * value:.0f} %"
