"""What is known of blendshape coefficients before depth is looked at: sparse, calm, even, and as the landmarker says.

The landmarker scores expressions itself. How far a score, its baseline taken out, lies from the coefficient was
measured shape by shape on films of tuning performers (`mien.stage.seeds`: 1, 2, 3), each shape played at a half and at
its whole, alone and mixed: the deviations below, over a take in which a shape plays in a seventh of the frames. Of
shapes that it does not tell from nothing (a deviation of 0.25) its scores are not used.

A take once tracked tells which shapes it needs; the others grow dearer. Two more things hold for anybody: the two
sides of a face move alike unless they are seen not to, eyes look the same way, and opposite shapes (mouth to the left,
mouth to the right) are not made at once.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from .fit_config import BlendshapeFitConfig

SCORE_DEVIATIONS = {
    "eyeBlink": 0.12, "eyeLookIn": 0.19, "eyeLookOut": 0.21, "eyeSquint": 0.24,
    "eyeWide": 0.24, "jawOpen": 0.12, "mouthSmile": 0.18, "mouthFunnel": 0.20, "mouthPucker": 0.21,
    "mouthStretch": 0.22, "mouthUpperUp": 0.23, "browInnerUp": 0.19, "browOuterUp": 0.19, "browDown": 0.24,
}  # fmt: skip
"""Standard deviation of a coefficient about its score, by how the shape's name begins."""
SMALL_IN_DEPTH = ("eyeBlink", "eyeLook")
"""Lids and gaze: what the depth says of them is little, and wrong."""
OPPOSITE = (
    ("jawLeft", "jawRight"), ("mouthLeft", "mouthRight"), ("mouthSmileLeft", "mouthFrownLeft"),
    ("mouthSmileRight", "mouthFrownRight"), ("mouthFunnel", "mouthStretchLeft"), ("mouthFunnel", "mouthStretchRight"),
    ("mouthPucker", "mouthStretchLeft"), ("mouthPucker", "mouthStretchRight"), ("mouthFunnel", "cheekPuff"),
    ("browDownLeft", "browOuterUpLeft"), ("browDownRight", "browOuterUpRight"), ("eyeWideLeft", "eyeBlinkLeft"),
    ("eyeWideRight", "eyeBlinkRight"), ("eyeWideLeft", "eyeSquintLeft"), ("eyeWideRight", "eyeSquintRight"),
    ("eyeLookUpLeft", "eyeLookDownLeft"), ("eyeLookUpRight", "eyeLookDownRight"),
    ("eyeLookInLeft", "eyeLookOutLeft"), ("eyeLookInRight", "eyeLookOutRight"),
)  # fmt: skip
"""Shapes that undo each other."""
DEAREST = 6.0
"""Most that a shape's price is multiplied by: what is never used at a normal price need not be shut out."""
AT_ITS_MOST = 150
"""Frames in which a shape is used most: what is shown once in a long take, a wink, is used all the same."""
ONE_SIDED = ("jawLeft", "mouthLeft")
"""Shapes whose name ends in a side and that have no twin on the other."""


@dataclass(frozen=True)
class WeightPrior:
    """What holds of a rig's shapes, by their names."""

    score_trust: Float[np.ndarray, " k"]
    """1 / variance of a coefficient about its score; 0 where scores say nothing."""
    small_in_depth: Float[np.ndarray, " k"]
    """1 for lids and gaze."""
    symmetry: Float[np.ndarray, "k k"]
    """x' S x adds up the squared differences of the two sides."""
    opposition: Float[np.ndarray, "k k"]
    """x' O x is twice the sum of products of opposite shapes."""
    dearness: Float[np.ndarray, " k"]
    """What the price of each coefficient is multiplied by: 1 until a take has told."""


def weight_prior(names: tuple[str, ...]) -> WeightPrior:
    """The prior of shapes with ARKit names; of others nothing is known."""
    return WeightPrior(
        score_trust=np.array([_trust(name) for name in names]),
        small_in_depth=np.array([float(name.startswith(SMALL_IN_DEPTH)) for name in names]),
        symmetry=_symmetry(names),
        opposition=_opposition(names),
        dearness=np.ones(len(names)),
    )


def dearer_where_idle(prior: WeightPrior, weights: Float[np.ndarray, "frames k"], in_use: float) -> WeightPrior:
    """The prior with each shape's price raised by how little a take used it at the plain price.

    Reweighted l1 (Candes, Wakin and Boyd 2008), all of a shape's coefficients over the take being one group: what comes
    in faintly here and there fits errors of the depth, of the head's pose and of other shapes.

    Args:
        in_use: root mean square, over the frames in which a shape is used most, from which on the price stays as it
            is; 0 = it stays for all.
    """
    strongest = np.sort(weights**2, axis=0)[-AT_ITS_MOST:]
    used = np.sqrt(strongest.mean(axis=0))
    least = max(in_use / DEAREST, 1e-9)
    return replace(prior, dearness=np.maximum(in_use / np.maximum(used, least), 1.0))


def _trust(name: str) -> float:
    known = [deviation for start, deviation in SCORE_DEVIATIONS.items() if name.startswith(start)]
    return known[0] ** -2 if known else 0.0


def twin(name: str) -> str | None:
    """The shape that the other side makes at the same time; None for a shape of both sides, or of the right one."""
    if name.startswith(ONE_SIDED) or not name.endswith("Left"):
        return None
    stem = name.removesuffix("Left")
    turned = {"eyeLookIn": "eyeLookOut", "eyeLookOut": "eyeLookIn"}
    return turned.get(stem, stem) + "Right"


def _symmetry(names: tuple[str, ...]) -> np.ndarray:
    out = np.zeros((len(names), len(names)))
    for i, name in enumerate(names):
        other = twin(name)
        if other in names:
            j = names.index(other)
            out[[i, j], [i, j]] += 1
            out[[i, j], [j, i]] -= 1
    return out


def _opposition(names: tuple[str, ...]) -> np.ndarray:
    out = np.zeros((len(names), len(names)))
    for one, other in OPPOSITE:
        if one in names and other in names:
            i, j = names.index(one), names.index(other)
            out[[i, j], [j, i]] = 1
    return out


def add_priors(
    A: Float[np.ndarray, "c c"],
    b: Float[np.ndarray, " c"],
    x: Float[np.ndarray, " k"],
    before: Float[np.ndarray, " k"],
    scores: Float[np.ndarray, " k"] | None,
    prior: WeightPrior,
    size: Float[np.ndarray, " k"],
    config: BlendshapeFitConfig,
) -> None:
    """Add ridge, sparsity, stillness, evenness and the landmarker's scores to the change's equations, in place.

    Args:
        x: coefficients now.
        before: those of the last frame.
        scores: less their baseline, NaN where there is none.
        size: how far each shape moves the face, mm.
    """
    k = len(x)
    diagonal = np.full(k, config.ridge + config.temporal_weight)
    price = prior.dearness * (config.l1 + config.l1_per_mm * size) / (1 + x / config.reweight_eps)
    b[:k] += config.temporal_weight * before - diagonal * x - price / 2
    if scores is not None:
        trust = config.scores * (1 + (config.eyes - 1) * prior.small_in_depth) * prior.score_trust * np.isfinite(scores)
        b[:k] += trust * (np.nan_to_num(scores) - x)
        diagonal += trust
    coupling = config.symmetry * prior.symmetry + config.opposition * prior.opposition
    A[:k, :k] += coupling
    A[np.arange(k), np.arange(k)] += diagonal
    b[:k] -= coupling @ x
