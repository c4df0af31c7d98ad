"""Numpy twin of `photometric`."""

import numpy as np

from .photometric import FLOOR


def robust_normals(values, light, usable, scales, rounds, normals, weights):
    """A reweighted 3 x 3 system a pixel."""
    weights[:] = usable
    for _ in range(rounds):
        gram = np.einsum("pk,pki,pkj->pij", weights, light, light)
        floor = FLOOR * np.trace(gram, axis1=1, axis2=2) + 1e-30
        right = np.einsum("pk,pki,pk->pi", weights, light, values)
        normals[:] = np.linalg.solve(gram + floor[:, None, None] * np.eye(3), right[..., None])[..., 0]
        off = (values - np.einsum("pki,pi->pk", light, normals)) / scales[:, None]
        weights[:] = usable / (1 + off**2)
