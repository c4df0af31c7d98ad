"""Displacements of high-resolution surfaces from the base motion, at the texels of a map (Ma et al. 2008, fig. 2)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int

from ..mesh import Attachment
from .base_mesh import BaseMesh
from .texture_space import Texels, orthonormal, tangent_frames, texels, texture_gradients
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

    def base_motion(self, markers: Float[np.ndarray, "k 3"]) -> tuple[np.ndarray, np.ndarray]:
        """The thin shell under aligned markers: positions (p, 3), mm, and local frames (p, 3, 3) at the texels."""
        moved = self.shell.vertices(markers - self.reference)
        frames = tangent_frames(self.gradients, moved)
        at, faces = self.texels.attachment, self.shell.mesh.faces
        return interpolated(moved, at, faces), orthonormal(interpolated(frames, at, faces))

    def skin(self, aligned: Aligned) -> Float[np.ndarray, "p 3"]:
        """The frame's true skin at the texels, mm."""
        return interpolated(aligned.vertices, self.on_training, self.faces)

    def displacement(self, aligned: Aligned) -> Float[np.ndarray, "p 3"]:
        """From the base to the skin in the base's local frame (u, v, n), mm; NaN where there is no skin."""
        here, local = self.base_motion(aligned.markers)
        offset = np.einsum("pab,pb->pa", local, self.skin(aligned) - here)
        offset[~(np.linalg.norm(offset, axis=1) <= self.farthest_mm)] = np.nan
        return offset


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
