"""Mean curvature of a surface, the feature by which wrinkles are matched."""

import numpy as np
from jaxtyping import Float

from mien._kernels.curvature import patch_curvature
from mien.errors import BadInput

from .mesh import Mesh
from .operators import adjacency, vertex_normals


def mean_curvature(mesh: Mesh, radius: float = 2.0) -> Float[np.ndarray, " n"]:
    """Mean curvature of every vertex, 1/mm, positive where the surface bulges out: 1/r on a sphere of radius r.

    A quadratic patch is fitted to all vertices within `radius` (mm) that are joined to the vertex inside that ball
    (Cazals and Pouget 2003; Huang et al. 2011, sec. 6.2). 0 for vertices with no triangle or too few neighbours.

    Raises:
        BadInput: a radius that is not positive.
    """
    if not radius > 0:
        raise BadInput(f"mean curvature: radius is {radius} mm; give a positive one, a few edge lengths")
    vertices = np.ascontiguousarray(mesh.vertices, np.float64)
    A = adjacency(mesh.faces, len(vertices))
    normals = vertex_normals(vertices, mesh.faces)
    return patch_curvature(vertices, normals, A.indptr.astype(np.int64), A.indices.astype(np.int64), float(radius))


def curvature_features(
    curvature: Float[np.ndarray, " n"], threshold: float = 0.05, signed: bool = True
) -> Float[np.ndarray, " n"]:
    """Curvature with its small values set to zero: the noise of the scan (Huang et al. 2011, sec. 6.2).

    threshold: 1/mm; the paper's 0.05 is a radius of 20 mm. signed: bulges and creases both stay, |curvature| counts;
    else the paper's rule to the letter, values below the threshold, and so all creases, are zero.
    """
    size = np.abs(curvature) if signed else curvature
    return np.where(size < threshold, 0.0, curvature)
