"""Wrinkles that survive export: at most eight shapes whose weights are a function of the rig's (past the paper)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...rig import Performance, Rig
from ...transforms import Transform
from ..drive import drive_by_performance, stand_ins
from ..fit import DetailModel
from ..synthesize import SynthesisConfig, Synthesizer, coloured

WRINKLE = "wrinkle_{:02d}"
MOST = 8
"""Shapes: what engines blend without a second thought."""
STEPS = (0.5, 1.0)
"""Weights at which each of the rig's shapes is tried alone."""
SAMPLED = 120
"""Frames of the performance that are learnt from, beside those."""
ROUNDS = 200
"""Of the factorisation; the energy kept no longer changes after some 100."""
RIDGE = 1e-3
"""Of the weights' function, as a share of the features' mean square."""


@dataclass(frozen=True)
class WrinkleShapes:
    """Detail beyond the neutral's, factored."""

    shapes: Float[np.ndarray, "r n 3"]
    """Mm, on the dense base; each at its strongest at weight 1."""
    function: Float[np.ndarray, "f r"]
    """Weights of the wrinkles = features(weights of the rig) @ function, cut to 0..1."""
    kept: float
    """Share of the detail's energy that shapes and function keep, over the performance."""

    def weights(self, rig_weights: Float[np.ndarray, "t k"]) -> Float[np.ndarray, "t r"]:
        """In 0..1."""
        return np.clip(features(rig_weights) @ self.function, 0, 1)


def features(weights: Float[np.ndarray, "t k"]) -> Float[np.ndarray, "t f"]:
    """Each weight, and the products of all pairs: 0 at the neutral."""
    first, second = np.triu_indices(weights.shape[1])
    return np.concatenate([weights, weights[:, first] * weights[:, second]], axis=1)


def wrinkle_shapes(
    model: DetailModel, performance: Performance, config: SynthesisConfig, most: int = MOST
) -> tuple[Synthesizer, WrinkleShapes]:
    """Factor the detail of a rig's single shapes and of a performance: D = A B with A >= 0 (Ding et al. 2010).

    With `config.fine_map` the fine map stays out of the shapes: it goes as pictures.

    Raises:
        BadInput: a performance without frames, or one that never moves.
    """
    dense = replace(config, medium=True, fine_vertices=not config.fine_map, fine_map=False)
    synthesizer = Synthesizer(model, dense)
    count = len(performance.rig.names)
    singles = np.concatenate([np.zeros((1, count)), *(step * np.eye(count) for step in STEPS)])
    step = max(1, len(performance) // SAMPLED)
    played = np.concatenate([singles, performance.weights[::step]])
    rest, detail = detail_of(model, synthesizer, performance, played)
    flat = (detail - rest).reshape(len(played), -1).astype(np.float64)
    gram = flat @ flat.T
    if not np.trace(gram) > 0:
        raise BadInput("wrinkle shapes: the performance and its rig never move the markers")
    A = semi_nonnegative(gram, most)
    function, A = _function(features(played), A)
    fitted = np.clip(features(played) @ function, 0, 1)
    shapes = np.linalg.lstsq(fitted, flat, rcond=1e-6)[0]
    tail = slice(len(singles), None)
    left = ((flat[tail] - fitted[tail] @ shapes) ** 2).sum()
    kept = 1 - left / max((flat[tail] ** 2).sum(), 1e-30)
    return synthesizer, WrinkleShapes(shapes.reshape(most, -1, 3), function, float(kept))


def detail_of(
    model: DetailModel, synthesizer: Synthesizer, performance: Performance, weights: Float[np.ndarray, "t k"]
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "t n 3"]]:
    """What the maps add to the thin shell, at the neutral and under weights, mm, object space."""
    poses, tracked = Transform.identity(len(weights)), np.ones(len(weights), bool)
    posed = Performance(performance.rig, weights, poses, performance.rate, tracked)
    positions = drive_by_performance(model, posed).positions
    rest = synthesizer.frame(model.reference).vertices - synthesizer.shell(model.reference)
    added = [synthesizer.frame(frame).vertices - synthesizer.shell(frame) for frame in positions]
    return rest, np.stack(added)


def semi_nonnegative(gram: Float[np.ndarray, "t t"], rank: int) -> Float[np.ndarray, "t r"]:
    """A >= 0 of the best D = A B, from D D' alone."""
    values, vectors = np.linalg.eigh(gram)
    start = vectors[:, ::-1][:, : -(-rank // 2)] * np.sqrt(np.maximum(values[::-1][: -(-rank // 2)], 0))
    A = np.concatenate([np.maximum(start, 0), np.maximum(-start, 0)], axis=1)[:, :rank] + 1e-3 * np.abs(start).max()
    for _ in range(ROUNDS):
        inverse = np.linalg.pinv(A.T @ A)
        cross = gram @ A @ inverse
        square = inverse @ A.T @ gram @ A @ inverse
        up = np.maximum(cross, 0) + A @ np.maximum(-square, 0)
        down = np.maximum(-cross, 0) + A @ np.maximum(square, 0)
        A = A * np.sqrt(up / np.maximum(down, 1e-30))
    return A


def _function(given: np.ndarray, A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ridge regression of the factors, scaled to reach 1, on the features."""
    A = A / np.maximum(A.max(axis=0), 1e-30)
    square = given.T @ given
    square += RIDGE * np.trace(square) / len(square) * np.eye(len(square))
    return np.linalg.solve(square, given.T @ A), A


def with_wrinkles(model: DetailModel, performance: Performance, config: SynthesisConfig) -> tuple[Performance, float]:
    """The performance on the dense base: the rig's own shapes as the thin shell makes them, and the wrinkles beside.

    Returns it and the share of the detail's energy that is kept.
    """
    synthesizer, wrinkles = wrinkle_shapes(model, performance, config)
    rig, count = performance.rig, len(performance.rig.names)
    poses = Transform.identity(count)
    alone = Performance(rig, np.eye(count), poses, performance.rate, np.ones(count, bool))
    moved = stand_ins(model, alone)
    shell = synthesizer.shell(model.reference)
    deltas = np.stack([synthesizer.shell(frame) - shell for frame in moved])
    still = synthesizer.frame(model.reference)
    neutral = coloured(synthesizer.mesh.with_vertices(still.vertices.astype(float)), still)
    names = (*rig.names, *(WRINKLE.format(i + 1) for i in range(len(wrinkles.shapes))))
    whole = Rig(neutral, np.concatenate([deltas, wrinkles.shapes]).astype(float), names)
    weights = np.concatenate([performance.weights, wrinkles.weights(performance.weights)], axis=1)
    return replace(performance, rig=whole, weights=weights), wrinkles.kept
