"""Numpy twin of `texels`."""

import numpy as np


def displacements(base, frames, at_corners, at_weights, skin, on_corners, on_weights, farthest, out):
    """Skin minus base in the base's local frame at every texel."""
    normal = np.einsum("pc,pcd->pd", at_weights, frames[at_corners][:, :, 2])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    u = np.einsum("pc,pcd->pd", at_weights, frames[at_corners][:, :, 0])
    u -= (u * normal).sum(axis=1, keepdims=True) * normal
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    local = np.stack([u, np.cross(normal, u), normal], axis=1)
    here = np.einsum("pc,pcd->pd", at_weights, base[at_corners])
    there = np.einsum("pc,pcd->pd", on_weights, skin[on_corners])
    out[:] = np.einsum("pab,pb->pa", local, there - here)
    out[~(np.linalg.norm(there - here, axis=1) <= farthest)] = np.nan
