"""What motion that a rig's shapes miss says of them: a ridge regression on the weights, believed where it foretells."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Float32

from ...mesh import adjacency
from ..model import TrackingModel

BLOCKS = 10
"""Parts of the take that are left out by turns."""
FAINT_MM = 0.05
"""Motion of this size is as good as none: it is not foretold."""


@dataclass(frozen=True)
class CorrectionConfig:
    """How far motion that the shapes miss is believed to be theirs."""

    ridge: float = 0.15
    """Weight of each squared correction a frame: shapes whose mean squared weight is less change by less than half."""
    doubtful: float = 0.45
    """Share of the missed motion round a vertex, in parts of the take left out by turns, that corrections must foretell
    before what the final mesh adds changes it."""
    believed: float = 0.75
    """The share from which on it is taken whole."""
    along_ridge: float = 0.03
    """The ridge of what pictures say along the skin: their flow is smooth already."""
    around_mm: float = 20.0
    """Deviation of the window in which pictures must come nearer to the skin at rest."""
    falls_doubtful: float = 0.08
    """Share by which they must differ less before flow changes a shape. Where skin is smooth, flow follows shades,
    which come back with the weights too: pictures then differ by 0.05 less."""
    falls_believed: float = 0.14
    """The share from which on flow is taken whole."""


@dataclass
class MissedMotion:
    """Normal equations of missed motion on weights, a part of the take each: as much memory for any length."""

    gram: Float[np.ndarray, "blocks k k"]
    """W'W."""
    product: Float32[np.ndarray, "blocks k f3"]
    """W's."""
    square: Float[np.ndarray, "blocks f"]
    """Squared length of the motion, mm^2."""
    frames: int = 0
    """Frames that were counted."""

    def add(self, block: int, weights: Float[np.ndarray, " k"], missed: Float32[np.ndarray, "f 3"]) -> None:
        """Count a frame to one of the parts."""
        self.frames += 1
        self.gram[block] += np.outer(weights, weights)
        self.product[block] += np.outer(weights, missed).astype(np.float32)
        self.square[block] += (missed.astype(np.float64) ** 2).sum(axis=1)


def nothing_missed(shapes: int, vertices: int) -> MissedMotion:
    """Nothing seen yet."""
    return MissedMotion(
        gram=np.zeros((BLOCKS, shapes, shapes)),
        product=np.zeros((BLOCKS, shapes, 3 * vertices), np.float32),
        square=np.zeros((BLOCKS, vertices)),
    )


def corrections(gram: Float[np.ndarray, "k k"], product: Float[np.ndarray, "k f3"], ridge: float) -> np.ndarray:
    """The ridge regression: what each shape lacks at weight 1, (k, 3 f) mm."""
    return np.linalg.solve(gram + ridge * np.eye(len(gram)), product)


def foretold_share(sums: MissedMotion, near: sp.csr_matrix, ridge: float) -> Float[np.ndarray, " f"]:
    """The share of the squared motion missed round each vertex that corrections learnt from the other parts foretell.

    `near` (f, f) averages over neighbours. At most 1, and below 0 where they make it worse. With s the motion, W the
    weights of a part and G what the others say, |s - W G|^2 = |s|^2 - 2 G.(W's) + G.(W'W G), vertex by vertex.
    """
    gram, product = sums.gram.sum(axis=0), sums.product.sum(axis=0)
    left = np.zeros(sums.square.shape[1])
    for there, says, square in zip(sums.gram, sums.product, sums.square, strict=True):
        G = corrections(gram - there, product - says, ridge)
        gain = G * (2 * says - there @ G)
        left += square - gain.sum(axis=0).reshape(-1, 3).sum(axis=1)
    square = sums.square.sum(axis=0)
    return (near @ (square - left)) / (near @ square + sums.frames * FAINT_MM**2)


def averaging(faces: np.ndarray, vertices: int) -> sp.csr_matrix:
    """Averages over each vertex and what lies up to two edges off, (vertices, vertices)."""
    near = adjacency(faces, vertices) + sp.identity(vertices)
    once = sp.diags(1 / np.asarray(near.sum(axis=1)).ravel()) @ near
    return sp.csr_matrix(once @ once)


def believed_corrections(
    sums: MissedMotion, model: TrackingModel, config: CorrectionConfig
) -> Float[np.ndarray, "k f 3"]:
    """What is added to the front of each shape, mm at weight 1: nothing where it foretells nothing, or on the rim."""
    ridge = config.ridge * sums.frames
    found = corrections(sums.gram.sum(axis=0), sums.product.sum(axis=0), ridge)
    share = foretold_share(sums, averaging(model.faces, len(model.front)), ridge)
    belief = np.clip((share - config.doubtful) / (config.believed - config.doubtful), 0.0, 1.0)
    return found.reshape(model.shapes, -1, 3) * (belief * model.fade)[:, None]


def along_corrections(
    weights: Float[np.ndarray, "n k"],
    slip: Float[np.ndarray, "n f 3"],
    belief: Float[np.ndarray, " f"],
    model: TrackingModel,
    config: CorrectionConfig,
) -> Float[np.ndarray, "k f 3"]:
    """What is added to the front of each shape, mm at weight 1, that skin slips as it does in n frames."""
    product = weights.T @ slip.reshape(len(slip), -1)
    found = corrections(weights.T @ weights, product, config.along_ridge * len(weights))
    return found.reshape(model.shapes, -1, 3) * (belief * model.fade)[:, None]
