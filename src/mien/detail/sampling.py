"""Displacements of high-resolution surfaces from the base motion, at the texels of a map (Ma et al. 2008, fig. 2)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from .._kernels import texels as kernels
from ..mesh import Attachment
from .base_mesh import BaseMesh
from .texture_space import Texels, tangent_frames, texels, texture_gradients
from .thin_shell import ThinShell
from .training import Aligned, TrainingSet


@dataclass(frozen=True)
class Sampler:
    """Where the texels of one map lie on the base and on the training topology."""

    texels: Texels
    on_training: Attachment
    """The texels on the training topology."""
    faces: Int[np.ndarray, "m 3"]
    """Of the training topology."""
    gradients: tuple[sp.csr_matrix, sp.csr_matrix]
    """Of the base's texture coordinates."""
    shell: ThinShell
    reference: Float[np.ndarray, "k 3"]
    farthest_mm: float
    """Displacements beyond it are no skin and become NaN."""

    @cached_property
    def _places(self) -> tuple[np.ndarray, ...]:
        """Corners and weights on the base, then on the skin, as the compiled loop takes them."""
        pairs = ((self.texels.attachment, self.shell.mesh.faces), (self.on_training, self.faces))
        corners = [np.ascontiguousarray(faces[points.faces], np.int32) for points, faces in pairs]
        weights = [np.ascontiguousarray(points.barycentric, np.float32) for points, _ in pairs]
        return corners[0], weights[0], corners[1], weights[1]

    def displacement(self, aligned: Aligned) -> Float[np.ndarray, "p 3"]:
        """From the base to the skin in the base's local frame (u, v, n), mm; NaN where there is no skin."""
        moved = self.shell.vertices(aligned.markers - self.reference)
        frames = tangent_frames(self.gradients, moved)
        skin = np.ascontiguousarray(aligned.vertices, float)
        at_corners, at_weights, on_corners, on_weights = self._places
        out = np.empty((len(at_corners), 3))
        kernels.displacements(
            moved, frames, at_corners, at_weights, skin, on_corners, on_weights, self.farthest_mm, out
        )
        return out


def sampler(training: TrainingSet, base: BaseMesh, shell: ThinShell, size: int, farthest_mm: float) -> Sampler:
    """The texels of a map of side `size`, looked up once."""
    grid = texels(base.mesh, size)
    return Sampler(
        texels=grid,
        on_training=base.on_training(grid.attachment),
        faces=training.mesh.faces,
        gradients=texture_gradients(base.mesh),
        shell=shell,
        reference=training.markers,
        farthest_mm=farthest_mm,
    )


def interpolated(values: Float[np.ndarray, "n *c"], points: Attachment, faces: Int[np.ndarray, "m 3"]) -> np.ndarray:
    """Vertex values at surface points."""
    return np.einsum("pc,pc...->p...", points.barycentric, values[faces[points.faces]])
