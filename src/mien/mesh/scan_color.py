"""Colour of a scan on its vertices, wherever the file keeps it."""

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from . import Mesh, Scan


def vertex_colours(scan: Scan) -> Float[np.ndarray, "n 3"] | None:
    """sRGB in 0..1 a vertex: from the texture, at one of the vertex's corners, else from the vertices; else None."""
    mesh = scan.mesh
    if scan.texture is None or mesh.uv is None:
        return mesh.colors
    corners = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
    uv = np.zeros((len(mesh.vertices), 2))
    uv[mesh.faces.ravel()] = mesh.uv[corners.ravel()]
    height, width = scan.texture.shape[:2]
    x = np.clip(np.round(uv[:, 0] % 1.0 * width - 0.5), 0, width - 1).astype(int)
    y = np.clip(np.round((1 - uv[:, 1] % 1.0) * height - 0.5), 0, height - 1).astype(int)
    return scan.texture[y, x] / 255.0


def recoloured(mesh: Mesh, scan: Scan) -> Mesh:
    """`mesh`, made of vertices of `scan` in the same places, with the scan's colours."""
    colours = vertex_colours(scan)
    if colours is None:
        return mesh
    where = KDTree(scan.mesh.vertices).query(mesh.vertices)[1]
    return Mesh(mesh.vertices, mesh.faces, colors=np.ascontiguousarray(colours[where]))
