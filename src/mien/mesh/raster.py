"""A surface laid out in an image: values drawn into it, and image points taken back to the surface."""

from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from mien._kernels.raster import scan_convert
from mien.errors import BadInput

from .closest import ClosestPoint
from .mesh import Attachment, Mesh


class SurfaceImage:
    """Triangles laid out flat, and which of them each pixel shows. Build once, draw many.

    uv (n, 2): the mesh's vertices in pixels (x, y), centres at integers, y down; faces (m, 3) of the mesh;
    shape: height and width of the image.

    Raises:
        BadInput: places that are not finite or are not as many as the faces need.
    """

    def __init__(self, uv: Float[np.ndarray, "n 2"], faces: Int[np.ndarray, "m 3"], shape: tuple[int, int]):
        if not np.isfinite(uv).all() or (len(faces) and faces.max() >= len(uv)):
            raise BadInput(f"surface image: {len(uv)} places must be finite and one a vertex of the faces")
        self.uv = np.ascontiguousarray(uv, np.float64)
        self.mesh_faces = np.ascontiguousarray(faces, np.int64)
        self.faces: Int[np.ndarray, "h w"] = np.full(shape, -1, np.int64)
        """The triangle under each pixel; -1 where there is none."""
        self.barycentric: Float[np.ndarray, "h w 3"] = np.zeros((*shape, 3))
        """Where in it the pixel's centre is."""
        scan_convert(self.uv, self.mesh_faces, self.faces, self.barycentric)

    @property
    def mask(self) -> Bool[np.ndarray, "h w"]:
        """Pixels that show the surface."""
        return self.faces >= 0

    def draw(self, values: Float[np.ndarray, "n *c"]) -> Float[np.ndarray, "h w *c"]:
        """Vertex values interpolated into the image; NaN where there is no surface."""
        image = np.full((*self.faces.shape, *values.shape[1:]), np.nan)
        mask = self.mask
        corners = values[self.mesh_faces[self.faces[mask]]]
        image[mask] = np.einsum("pc,pc...->p...", self.barycentric[mask], corners)
        return image

    def surface_at(self, points: Float[np.ndarray, "p 2"]) -> Attachment:
        """The surface points that image points (x, y) show; off the surface, the nearest that the image does show."""
        found = self._flat.query(np.column_stack([points, np.zeros(len(points))]))
        bary = np.clip(found.barycentric, 0, 1)
        return Attachment(found.faces, bary / bary.sum(1, keepdims=True))

    @cached_property
    def _flat(self) -> ClosestPoint:
        return ClosestPoint(Mesh(np.column_stack([self.uv, np.zeros(len(self.uv))]), self.mesh_faces))
