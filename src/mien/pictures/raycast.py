"""Rays against a mesh: any rays through Embree, the rays of a pinhole camera through a compiled z-buffer.

Both give triangles and barycentric coordinates; points follow from those in float64, so that neither a mesh far from
the origin nor Embree's single precision shows as noise.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Bool, Float, Int

from .._kernels.zbuffer import pixel_weights, zbuffer
from ..camera import Camera
from ..mesh import Attachment, Mesh
from ..transforms import Transform


class Hits(NamedTuple):
    """What `RayCaster.cast` found, one row a ray."""

    faces: Int[np.ndarray, " r"]
    """The first triangle on the ray; -1 for none."""
    barycentric: Float[np.ndarray, "r 3"]
    """On that triangle; NaN for none."""
    distances: Float[np.ndarray, " r"]
    """Along the ray, in lengths of its direction (millimetres where that is a unit vector); NaN for none."""
    hit: Bool[np.ndarray, " r"]

    def attachment(self) -> Attachment:
        """The points of the rays that hit (`hit` of them), fixed on the surface."""
        return Attachment(self.faces[self.hit], self.barycentric[self.hit])


class DepthImage(NamedTuple):
    """What a camera sees of a mesh, pixel by pixel."""

    faces: Int[np.ndarray, "h w"]
    """The triangle at the pixel's centre; -1 for none."""
    barycentric: Float[np.ndarray, "h w 3"]
    """On that triangle; NaN for none."""
    depth: Float[np.ndarray, "h w"]
    """Camera z, millimetres; NaN for none."""


class RayCaster:
    """A mesh made ready for rays: build once, cast often."""

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        self._faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)

    @cached_property
    def _scene(self) -> tuple[EmbreeScene, TriangleMesh, np.ndarray]:
        """Embree's tree in coordinates round the mesh's centre, where float32 is finest."""
        centre = (self.mesh.vertices.min(0) + self.mesh.vertices.max(0)) / 2
        scene = EmbreeScene(robust=True)
        corners = np.ascontiguousarray(self.mesh.vertices - centre, dtype=np.float32)
        return scene, TriangleMesh(scene, corners, self._faces.astype(np.int32)), centre

    def cast(
        self, origins: Float[np.ndarray, "r 3"], directions: Float[np.ndarray, "r 3"], reach: float = np.inf
    ) -> Hits:
        """The first triangle on each ray, from either side, no farther than `reach`.

        Args:
            origins: (r, 3), millimetres, in the mesh's space.
            directions: (r, 3), of any length but zero.
            reach: greatest distance, in lengths of the direction.
        """
        scene, _, centre = self._scene
        start = np.ascontiguousarray(origins - centre, dtype=np.float32)
        found = scene.run(start, np.ascontiguousarray(directions, dtype=np.float32), dists=min(reach, 1e30), output=1)
        faces = found["primID"].astype(np.int64)
        hit = faces >= 0
        barycentric, distances = np.full((len(faces), 3), np.nan), np.full(len(faces), np.nan)
        corners = self.mesh.vertices[self._faces[faces[hit]]]
        barycentric[hit], distances[hit] = _meet(corners - origins[hit, None], directions[hit])
        return Hits(faces, barycentric, distances, hit)

    def occluded(
        self, origins: Float[np.ndarray, "r 3"], directions: Float[np.ndarray, "d 3"], reach: float = np.inf
    ) -> Bool[np.ndarray, " r"]:
        """Whether anything at all is on each ray within `reach`: cheaper than `cast`. One direction serves all rays."""
        scene, _, centre = self._scene
        start = np.ascontiguousarray(origins - centre, dtype=np.float32)
        way = np.ascontiguousarray(directions, dtype=np.float32)
        return scene.run(start, way, dists=min(reach, 1e30), query="OCCLUDED") >= 0

    def depth_image(self, camera: Camera, T_camera_face: Transform) -> DepthImage:
        """What `camera` sees of the mesh: triangle, barycentric coordinates and depth at each pixel's centre."""
        return depth_image(self.mesh, camera, T_camera_face)


def depth_image(mesh: Mesh, camera: Camera, T_camera_face: Transform) -> DepthImage:
    """What `camera` sees of the mesh: triangle, barycentric coordinates and depth at each pixel's centre.

    Exact rays in float64 (no tree to build: fit for a mesh that moves every frame), either side of a triangle.
    """
    points = T_camera_face.apply(mesh.vertices)
    intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
    faces, nearness = zbuffer(points, mesh.faces, intrinsics, camera.height, camera.width)
    seen = np.flatnonzero(faces.reshape(-1) >= 0)
    barycentric = np.full((*faces.shape, 3), np.nan)
    barycentric.reshape(-1, 3)[seen] = pixel_weights(points, mesh.faces, intrinsics, faces, seen)
    return DepthImage(faces, barycentric, np.where(faces >= 0, 1 / np.where(nearness > 0, nearness, 1), np.nan))


def _meet(corners: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric coordinates and distance where rays from 0 along `directions` meet the planes of `corners` (r, 3, 3).

    A ray that Embree found on the rim of a triangle is kept on it.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    edges = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], 1)
    weights = np.einsum("rcd,rd->rc", edges, directions)
    total = weights.sum(1, keepdims=True)
    weights = np.clip(weights / np.where(total == 0, 1, total), 0, None)
    weights = np.where(weights.sum(1, keepdims=True) > 0, weights, 1.0)
    weights /= weights.sum(1, keepdims=True)
    points = np.einsum("rc,rcd->rd", weights, corners)
    return weights, np.einsum("rd,rd->r", points, directions) / np.einsum("rd,rd->r", directions, directions)
