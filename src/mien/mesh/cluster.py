"""A mesh thinned in an instant, for what needs its shape only roughly."""

import numpy as np

from .mesh import Mesh


def clustered(mesh: Mesh, cell: float) -> Mesh:
    """Vertices in the same cube of side `cell` (mm) become their mean; triangles that this flattens are left out.

    Rossignac and Borrel 1993. Fast and careless: thin parts may be joined. Colours and texture are dropped.
    """
    used = np.unique(mesh.faces)
    keys = np.floor(mesh.vertices[used] / cell).astype(np.int64)
    _, where, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    where = where.reshape(-1)
    middle = np.stack([np.bincount(where, mesh.vertices[used, d]) / count for d in range(3)], 1)
    new = np.zeros(len(mesh.vertices), np.int64)
    new[used] = where
    faces = new[mesh.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Mesh(middle, faces[np.sort(once)])
