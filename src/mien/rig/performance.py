"""A rig in motion: what every capture ends in and every export starts from."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..mesh import Mesh
from ..one_line import count, one_line
from ..transforms import Transform
from .rig import Rig


@dataclass(frozen=True)
class Performance:
    """Weights and head pose, frame by frame."""

    rig: Rig
    weights: Float[np.ndarray, "frames shapes"]
    """In the rig's order; 0..1 for ARKit shapes."""
    T_world_face: Transform
    """Head pose, one a frame: face space -> the take's world (lab turned to +Y up), millimetres."""
    rate: float
    """Frames a second; time 0 is the first frame."""
    tracked: Bool[np.ndarray, " frames"]
    """False where the take had nothing to go by: such frames hold the last value."""

    def __repr__(self) -> str:
        frames = count(len(self), "frames")
        taken = f"{frames} at {self.rate:g} a second ({len(self) / self.rate:.1f} s)"
        return one_line(self, taken, f"{int(np.sum(self.tracked)):,} tracked", self.rig)

    def __post_init__(self):
        t, k = self.weights.shape
        if k != len(self.rig.names):
            raise ValueError(f"weights: expected {len(self.rig.names)} a frame, one a shape of the rig, got {k}")
        if len(self.T_world_face) != t or len(self.tracked) != t:
            got = f"{len(self.T_world_face)}, {len(self.tracked)}"
            raise ValueError(f"T_world_face, tracked: expected {t} frames, got {got}")

    def __len__(self) -> int:
        return len(self.weights)

    def meshes(self, world: bool = False) -> Iterator[Mesh]:
        """One mesh a frame, streamed; in face space, or with `world` placed in the take."""
        for t in range(len(self)):
            mesh = self.rig.mesh(self.weights[t])
            yield mesh.with_vertices(self.T_world_face[t].apply(mesh.vertices)) if world else mesh
