"""What the blendshapes cannot say, as shapes of their own: a tracked take becomes a rig and weights, nothing else."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32

from ..rig import Rig
from ..rig.unit_weights import corrective_names
from .model import TrackingModel


@dataclass(frozen=True)
class CorrectiveConfig:
    """How closely the final mesh is kept."""

    shapes: int = 24
    """Most corrective shapes; 0 = none, the blendshapes alone."""
    tolerance: float = 0.03
    """Shapes that move the front by less than this, mm root mean square over the take, are left out."""
    block: int = 200
    """Frames worked on at a time."""


class CorrectiveBasis:
    """The leading directions of a stream of residuals, and every frame's coefficients in them.

    Frames are merged in blocks: the singular vectors so far, times their sizes, stand for the frames before.
    """

    def __init__(self, model: TrackingModel, config: CorrectiveConfig = CorrectiveConfig()):
        self._model, self._config = model, config
        self._root = np.repeat(np.sqrt(model.share), 3)
        self._block: list[np.ndarray] = []
        self._basis = np.zeros((model.neutral.size, 0), np.float32)
        self._rows = np.zeros((0, 0), np.float32)

    def add(self, residual: Float32[np.ndarray, "f 3"]) -> None:
        """Take one frame: final mesh minus blendshapes on the front, face space, mm."""
        if not self._config.shapes:
            return
        faded = residual * self._model.fade[:, None]
        self._block.append((faded.ravel() * self._root).astype(np.float32))
        if len(self._block) >= self._config.block:
            self._merge()

    def _merge(self) -> None:
        if not self._block:
            return
        new = np.stack(self._block, 1)
        sizes = np.linalg.norm(self._rows, axis=0)
        stacked = np.concatenate([self._basis * sizes, new], 1)
        values, vectors = np.linalg.eigh((stacked.T @ stacked).astype(np.float64))
        keep = np.argsort(values)[::-1][: self._config.shapes]
        keep = keep[values[keep] > 1e-9 * max(values.max(), 1e-30)]
        basis = stacked @ (vectors[:, keep] / np.sqrt(values[keep])).astype(np.float32)
        self._rows = np.concatenate([self._rows @ (self._basis.T @ basis), new.T @ basis])
        self._basis, self._block = basis, []

    def finish(self) -> tuple[Float[np.ndarray, "c f 3"], Float[np.ndarray, "frames c"]]:
        """Corrective displacements of the front (mm at weight 1, their largest) and weights in -1..1."""
        self._merge()
        size = np.sqrt((self._rows**2).mean(0)) if len(self._rows) else np.zeros(self._basis.shape[1])
        keep = size > self._config.tolerance
        basis, rows = self._basis[:, keep] / np.maximum(self._root, 1e-6)[:, None], self._rows[:, keep]
        largest = np.maximum(np.abs(rows).max(0, initial=1e-12), 1e-12)
        shapes = (basis * largest).T.reshape(-1, len(self._model.front), 3)
        return shapes.astype(np.float64), (rows / largest).astype(np.float64)


def with_correctives(rig: Rig, model: TrackingModel, shapes: Float[np.ndarray, "c f 3"]) -> Rig:
    """The rig with the corrective shapes behind its own, named corrective_01 onwards."""
    deltas = np.zeros((len(shapes), *rig.neutral.vertices.shape))
    deltas[:, model.front] = shapes
    names = rig.names + corrective_names(len(shapes))
    return Rig(rig.neutral, np.concatenate([rig.deltas, deltas]), names, rig.texture)
