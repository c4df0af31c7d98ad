"""Base motion: a smooth neutral mesh deformed to the markers by a linear thin shell (Ma et al. 2008, sec. 4)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float
from scipy.sparse.linalg import splu

from ..errors import BadInput
from ..mesh import Attachment, Mesh, cotangent_laplacian, mass

ANCHOR = 1e-9
"""Weight of a displacement itself, 1/mm^2 of area: it makes the system regular where no marker hangs, and no more."""


@dataclass(frozen=True)
class ShellConfig:
    """How the shell resists."""

    bending_mm: float = 10.0
    """Length below which bending costs more than stretching, mm; 0: a membrane, which is pointed at the markers."""
    softness_mm: float = 0.0
    """How far a marker may stay off its place at unit load; 0: markers are met exactly."""

    def __post_init__(self):
        if self.bending_mm < 0 or self.softness_mm < 0:
            raise BadInput("thin shell: bending_mm and softness_mm are lengths, 0 or more")


@dataclass(frozen=True)
class ThinShell:
    """A mesh that follows its markers: one product a frame."""

    mesh: Mesh
    """At rest, face space, mm."""
    response: Float[np.ndarray, "n k"]
    """Displacement of every vertex for a unit displacement of each marker."""
    config: ShellConfig

    def vertices(self, offsets: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "n 3"]:
        """The shell under markers displaced by `offsets` from the neutral, mm."""
        return self.mesh.vertices + self.response @ offsets


def thin_shell(mesh: Mesh, attachment: Attachment, config: ShellConfig = ShellConfig()) -> ThinShell:
    """Factorise the shell once (Bickel et al. 2007, eq. 1): k_s L d + k_b L M^-1 L d = forces at the markers.

    K = L + b^2 L M^-1 L, with b the bending length. The response to the markers is G (D G + s^2 I)^-1 with K G = D':
    the solution for displacements given at the markers, softened by s.

    Raises:
        BadInput: two markers on one spot, which no displacement can tell apart.
    """
    D = attachment.matrix(mesh)
    L, area = cotangent_laplacian(mesh.vertices, mesh.faces), mass(mesh.vertices, mesh.faces)
    area = np.maximum(area, 1e-3 * area.mean())
    bend = L.T @ sp.diags(1 / area) @ L
    K = L + config.bending_mm**2 * bend + ANCHOR * sp.diags(area)
    factor = splu(sp.csc_matrix(K), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    G = factor.solve(np.ascontiguousarray(D.T.toarray()))
    meets = D @ G + config.softness_mm**2 * np.eye(len(attachment.faces))
    if np.linalg.cond(meets) > 1e14:
        raise BadInput("thin shell: two markers sit on one spot; leave one of them out")
    return ThinShell(mesh, np.ascontiguousarray(G @ np.linalg.inv(meets)), config)
