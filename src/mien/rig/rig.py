"""The blendshape rig: a neutral face and named displacements (Casas 2016, eq. 1-3)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8

from ..mesh import Mesh
from ..one_line import count, one_line


@dataclass(frozen=True)
class Rig:
    """f = b0 + sum_k w_k m_k (b_k - b0), in face space, millimetres."""

    neutral: Mesh
    """b0."""
    deltas: Float[np.ndarray, "shapes n 3"]
    """m_k (b_k - b0): masks are multiplied in."""
    names: tuple[str, ...]
    """One a shape, all different; the 52 ARKit names where the shapes are those."""
    texture: UInt8[np.ndarray, "h w 3"] | None = None
    """Colour for the neutral's uv."""

    def __repr__(self) -> str:
        n = count(len(self.neutral.vertices), "vertices")
        return one_line(self, count(len(self.names), "shapes"), n, None if self.texture is None else "texture")

    def __post_init__(self):
        if len(self.names) != len(self.deltas) or len(set(self.names)) != len(self.names):
            raise ValueError(f"names: expected {len(self.deltas)} different ones, one a shape, got {self.names}")
        if self.deltas.shape[1:] != self.neutral.vertices.shape:
            raise ValueError(f"deltas: expected (shapes, {len(self.neutral.vertices)}, 3), got {self.deltas.shape}")

    def vertices(self, weights: Float[np.ndarray, "*batch shapes"]) -> Float[np.ndarray, "*batch n 3"]:
        """The shape under `weights`, for one frame or a batch (mind the memory: batch * n * 3 doubles)."""
        k, n, _ = self.deltas.shape
        moved = (weights @ self.deltas.reshape(k, n * 3)).reshape(*weights.shape[:-1], n, 3)
        return moved + self.neutral.vertices

    def mesh(self, weights: Float[np.ndarray, " shapes"]) -> Mesh:
        """The face under one frame's weights."""
        return self.neutral.with_vertices(self.vertices(weights))

    def with_shapes(self, neutral: Mesh, deltas: Float[np.ndarray, "shapes n 3"]) -> "Rig":
        """The same names and texture on another person."""
        return replace(self, neutral=neutral, deltas=deltas)

    def index(self, name: str) -> int:
        """Which shape bears `name`.

        Raises:
            KeyError: none does.
        """
        try:
            return self.names.index(name)
        except ValueError:
            raise KeyError(f"no shape named {name!r}; there are {', '.join(self.names)}") from None
