"""`zbuffer` in numpy: every triangle against every pixel."""

import numpy as np


def zbuffer(points, faces, intrinsics, height, width):
    """As `mien._kernels.zbuffer.zbuffer`."""
    rays = _rays(intrinsics, height, width)
    face_image, nearness = np.full((height, width), -1, dtype=np.int32), np.zeros((height, width))
    for f, corners in enumerate(points[faces]):
        determinant = np.linalg.det(corners.T)
        if determinant == 0:
            continue
        weights = _edges(corners) @ rays.reshape(-1, 3).T * np.sign(determinant)
        near = weights.sum(0).reshape(height, width) / abs(determinant)
        closer = (weights >= 0).all(0).reshape(height, width) & (near > nearness)
        face_image[closer], nearness[closer] = f, near[closer]
    return face_image, nearness


def pixel_weights(points, faces, intrinsics, face_image, pixels):
    """As `mien._kernels.zbuffer.pixel_weights`."""
    rays = _rays(intrinsics, *face_image.shape).reshape(-1, 3)[pixels]
    corners = points[faces[face_image.reshape(-1)[pixels]]]
    weights = np.array([_edges(c) @ ray for c, ray in zip(corners, rays, strict=True)]).reshape(-1, 3)
    return weights / weights.sum(1, keepdims=True)


def _rays(intrinsics, height, width):
    fx, fy, cx, cy = intrinsics
    x, y = np.meshgrid((np.arange(width) - cx) / fx, (np.arange(height) - cy) / fy)
    return np.stack([x, y, np.ones_like(x)], -1)


def _edges(corners):
    a, b, c = corners
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
