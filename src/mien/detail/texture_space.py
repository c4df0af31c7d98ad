"""The texture space that displacement maps live in: a base mesh with one-to-one texture coordinates, and its texels."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from ..errors import BadInput
from ..mesh import Attachment, Mesh, SurfaceImage, face_areas, unroll_face

UNROLL_PIXEL_MM = 0.5
"""Scale at which a face is unrolled before its layout is stretched to the unit square; any will do."""


@dataclass(frozen=True)
class Texels:
    """The texels of a square map that show the surface, row by row."""

    size: int
    """Side of the map, texels."""
    pixels: Int[np.ndarray, " p"]
    """row * size + column of each; rows count from the top, as in image files."""
    attachment: Attachment
    """Where on the base mesh each one's centre is."""

    def image(self, values: Float[np.ndarray, "p *c"]) -> Float[np.ndarray, "size size *c"]:
        """Texel values as an image; NaN where there is no surface."""
        out = np.full((self.size * self.size, *values.shape[1:]), np.nan, values.dtype)
        out[self.pixels] = values
        return out.reshape(self.size, self.size, *values.shape[1:])

    def of_image(self, image: Float[np.ndarray, "size size *c"]) -> Float[np.ndarray, "p *c"]:
        """The image's values at the texels."""
        return image.reshape(self.size * self.size, *image.shape[2:])[self.pixels]


def with_texture(mesh: Mesh) -> Mesh:
    """The mesh with texture coordinates that go with its vertices: its own, or those of an unrolled cylinder.

    Raises:
        BadInput: coordinates with seams inside the face, or a mesh that cannot be unrolled.
    """
    if mesh.uv is not None and mesh.uv_faces is None and len(mesh.uv) == len(mesh.vertices):
        return mesh
    if mesh.uv is not None and mesh.uv_faces is not None and np.array_equal(mesh.uv_faces, mesh.faces):
        return replace(mesh, uv_faces=None)
    unrolled = unroll_face(mesh, UNROLL_PIXEL_MM)
    height, width = unrolled.shape
    side = max(height, width)
    uv = np.stack([unrolled.uv[:, 0] + 0.5, height - 0.5 - unrolled.uv[:, 1]], 1) / side
    return replace(mesh, uv=uv, uv_faces=None)


def texels(mesh: Mesh, size: int) -> Texels:
    """The texels of a size x size map of a mesh `with_texture`.

    Raises:
        BadInput: no texel shows the surface.
    """
    assert mesh.uv is not None
    places = np.stack([mesh.uv[:, 0] * size - 0.5, (1 - mesh.uv[:, 1]) * size - 0.5], 1)
    image = SurfaceImage(places, mesh.faces, (size, size))
    seen = np.flatnonzero(image.mask.ravel())
    if not len(seen):
        raise BadInput("texture space: no texel shows the surface; are the texture coordinates in 0..1?")
    return Texels(size, seen, Attachment(image.faces.ravel()[seen], image.barycentric.reshape(-1, 3)[seen]))


def texel_mm(mesh: Mesh, size: int) -> float:
    """Mean side of a texel on the surface, mm."""
    assert mesh.uv is not None
    area = face_areas(mesh.vertices, mesh.faces).sum()
    flat = np.column_stack([mesh.uv, np.zeros(len(mesh.uv))])
    return float(np.sqrt(area / face_areas(flat, mesh.faces).sum()) / size)


def texture_gradients(mesh: Mesh) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """Matrices (n, n) that take vertex positions to dP/du and dP/dv at the vertices, area-weighted means.

    They belong to the texture coordinates alone, so that one pair serves the mesh in every shape.
    """
    assert mesh.uv is not None
    a, b, c = (mesh.uv[mesh.faces[:, i]] for i in range(3))
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    along_u = np.stack([b[:, 1] - c[:, 1], c[:, 1] - a[:, 1], a[:, 1] - b[:, 1]], 1)
    along_v = np.stack([c[:, 0] - b[:, 0], a[:, 0] - c[:, 0], b[:, 0] - a[:, 0]], 1)
    n = len(mesh.vertices)
    total = np.bincount(mesh.faces.ravel(), np.repeat(np.abs(twice), 3), minlength=n)
    share = sp.diags(1 / np.maximum(total, 1e-30))
    sign = np.sign(twice)[:, None]
    rows = np.repeat(mesh.faces, 3, axis=1).ravel()
    columns = np.tile(mesh.faces, (1, 3)).ravel()
    u, v = (
        sp.csr_matrix((np.tile(sign * along, (1, 3)).ravel(), (rows, columns)), shape=(n, n))
        for along in (along_u, along_v)
    )
    return sp.csr_matrix(share @ u), sp.csr_matrix(share @ v)


def tangent_frames(
    gradients: tuple[sp.csr_matrix, sp.csr_matrix], vertices: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n 3 3"]:
    """At every vertex the unit vectors u (along dP/du), v and n (outwards), as rows."""
    u, v = gradients[0] @ vertices, gradients[1] @ vertices
    normal = np.cross(u, v)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    u = u - (u * normal).sum(1, keepdims=True) * normal
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-12)
    return np.stack([u, np.cross(normal, u), normal], 1)


def with_gutter(image: Float[np.ndarray, "h w *c"]) -> Float[np.ndarray, "h w *c"]:
    """The image with every NaN texel given its nearest known one's value, so that it may be read between texels."""
    unknown = ~np.isfinite(image.reshape(*image.shape[:2], -1)).all(axis=2)
    nearest = np.asarray(ndimage.distance_transform_edt(unknown, return_distances=False, return_indices=True))
    return image[nearest[0], nearest[1]]


def resampling(mesh: Mesh, known: Texels, wanted: Texels) -> sp.csr_matrix:
    """The matrix (q, p) that reads values at the texels of one map, bilinear, at those of another."""
    assert mesh.uv is not None
    corners = mesh.uv[mesh.faces[wanted.attachment.faces]]
    uv = np.einsum("pc,pcd->pd", wanted.attachment.barycentric, corners)
    columns, parts = four_texels(known, np.ones(len(known.pixels), bool), uv)
    count = len(uv)
    shape = (count, len(known.pixels))
    start = np.arange(0, 4 * count + 1, 4)
    return sp.csr_matrix((parts.ravel().astype(np.float32), columns.ravel(), start), shape=shape)


def four_texels(
    known: Texels, usable: Bool[np.ndarray, " p"], uv: Float[np.ndarray, "n 2"]
) -> tuple[Int[np.ndarray, "n 4"], Float[np.ndarray, "n 4"]]:
    """Of each point the four texels round it, by their number in the list, and their shares of a bilinear mean.

    The nearest usable texel stands in for one that is not, or off the surface.
    """
    numbers = known.image(np.where(usable, np.arange(len(known.pixels)), np.nan))
    numbers = with_gutter(numbers).astype(np.int64)
    x = np.clip(uv[:, 0] * known.size - 0.5, 0, known.size - 1.001)
    y = np.clip((1 - uv[:, 1]) * known.size - 0.5, 0, known.size - 1.001)
    column, row = x.astype(int), y.astype(int)
    across, down = x - column, y - row
    columns = np.stack([numbers[row + i, column + j] for i in (0, 1) for j in (0, 1)], 1)
    parts = [(across if j else 1 - across) * (down if i else 1 - down) for i in (0, 1) for j in (0, 1)]
    return columns, np.stack(parts, 1)


def sample(image: Float[np.ndarray, "h w *c"], uv: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n *c"]:
    """A map (with its gutter) at texture coordinates, bilinear."""
    height, width = image.shape[:2]
    x = np.clip(uv[:, 0] * width - 0.5, 0, width - 1.001)
    y = np.clip((1 - uv[:, 1]) * height - 0.5, 0, height - 1.001)
    column, row = x.astype(int), y.astype(int)
    across, down = (part.reshape(-1, *[1] * (image.ndim - 2)) for part in (x - column, y - row))
    upper = image[row, column] * (1 - across) + image[row, column + 1] * across
    lower = image[row + 1, column] * (1 - across) + image[row + 1, column + 1] * across
    return upper * (1 - down) + lower * down
