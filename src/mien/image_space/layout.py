"""One image for all scans: where every vertex of every scan is laid out, and the way back to its surface.

The scans share their triangles, so one layout of the mean shape is a one-to-one layout of each of them: the paper lays
out every scan by itself. A vertex slides on a scan's surface by moving in the image over that scan's fixed triangles.
"""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from jaxtyping import Bool, Float, Int
from scipy import ndimage
from scipy.spatial import KDTree

from ..errors import BadInput
from ..mesh import Attachment, Mesh, SurfaceImage, cotangent_laplacian, submesh, unroll_face

SHOWN = 0.05
"""Triangles count as face where the masks of the regions add up to this."""
HALVINGS = 6
"""How often a step is halved round triangles that it would turn over, before their corners stay where they are."""
SAMPLES = 4
"""A side of a pixel, where layers are looked for that lie over each other."""
SAME_MM = 0.01
"""Two layers are farther apart than this."""
HELD_PIXELS = 2.0
"""How near them vertices stay where they are: hardly a step is longer."""


class Layout:
    """The face of a topology, unrolled: regions, their blending weights, and the smoothing of steps by eq. 11.

    Raises:
        BadInput: no triangle in any region, or a mesh that cannot be unrolled.
    """

    def __init__(self, mesh: Mesh, regions: dict[str, Float[np.ndarray, " n"]], pixel_mm: float, alpha: float):
        total = np.sum(list(regions.values()), axis=0)
        used = np.flatnonzero((total[mesh.faces] > SHOWN).all(axis=1))
        if not len(used):
            raise BadInput("fine registration: no triangle lies in any region; give masks of this topology")
        self.mesh, self.vertices = submesh(mesh, used)
        """The face alone, mean shape, and the vertices of the whole mesh that it has."""
        unrolled = unroll_face(self.mesh, pixel_mm)
        self.home: Float[np.ndarray, "n 2"] = unrolled.uv
        self.image: SurfaceImage = unrolled.image()
        self.alpha = alpha
        masks = np.stack([mask[self.vertices] for mask in regions.values()], 1)
        self.masks: Float[np.ndarray, "h w r"] = np.nan_to_num(self.image.draw(masks))
        self.weights: Float[np.ndarray, "h w r"] = blending(self.masks)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image."""
        return self.masks.shape[0], self.masks.shape[1]

    @cached_property
    def held(self) -> Bool[np.ndarray, " n"]:
        """Vertices that stay where they are: where layers lie over each other, and `HELD_PIXELS` round that.

        Unrolling forbids folds, not layers: at the corners of eyes and mouth one lid or lip may come to lie over the
        other, and a vertex that moved there would land on the wrong one.
        """
        double = self._double()
        if not len(double):
            return np.zeros(len(self.home), bool)
        return KDTree(double).query(self.home)[0] < HELD_PIXELS

    def _double(self) -> Float[np.ndarray, "k 2"]:
        """Places in the image that show two layers: which of them is drawn depends on the triangles' order."""
        finer, shape = SAMPLES * self.home, (SAMPLES * self.shape[0], SAMPLES * self.shape[1])
        orders = self.mesh.faces, self.mesh.faces[::-1]
        first, last = (SurfaceImage(finer, faces, shape).draw(self.mesh.vertices) for faces in orders)
        rows, columns = np.nonzero(np.linalg.norm(first - last, axis=2) > SAME_MM)
        return np.column_stack([columns, rows]) / SAMPLES

    @cached_property
    def _smoother(self) -> spl.SuperLU:
        L = cotangent_laplacian(self.mesh.vertices, self.mesh.faces)
        A = sp.identity(len(self.vertices)) + self.alpha * (L.T @ L)
        return spl.splu(sp.csc_matrix(A), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def smoothed(self, steps: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Eq. 11: what least squares make of the steps when differential coordinates are to stay."""
        return self._smoother.solve(np.ascontiguousarray(steps))

    def moved(self, uv: Float[np.ndarray, "n 2"], steps: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """`uv` after smoothed steps, halved where triangles would turn over, in the end to nothing; on the surface.

        What is `held` stays.

        No triangle turns over that was the right way round before.
        """
        stepped, home = self.smoothed(steps), signed_areas(self.home, self.mesh.faces)
        stepped[self.held] = 0.0
        already = signed_areas(uv, self.mesh.faces) * home <= 0
        new = self._inside(uv + stepped)
        for halving in range(len(self.home)):
            turned = (signed_areas(new, self.mesh.faces) * home < 0) & ~already
            if not turned.any():
                break
            stepped[np.unique(self.mesh.faces[turned])] *= 0.5 if halving < HALVINGS else 0.0
            new = self._inside(uv + stepped)
        return np.where(self.held[:, None], self.home, new)

    def _inside(self, uv: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """The closest places on the surface."""
        flat = Mesh(np.column_stack([self.home, np.zeros(len(self.home))]), self.mesh.faces)
        return self.image.surface_at(uv).points(flat)[:, :2]

    def on_surface(self, uv: Float[np.ndarray, "n 2"]) -> Attachment:
        """The surface points, on the triangles of `mesh`, that are laid out at `uv`."""
        return self.image.surface_at(uv)

    def place_of(self, attachment: Attachment) -> Float[np.ndarray, "p 2"]:
        """Where points of the surface are laid out."""
        return np.einsum("pc,pcd->pd", attachment.barycentric, self.home[self.mesh.faces[attachment.faces]])


def blending(masks: Float[np.ndarray, "h w r"]) -> Float[np.ndarray, "h w r"]:
    """Eq. 10's weights, 1 - cos(pi/2 d/l_d), with the mask for d/l_d: both go from 0 to 1 over an overlap's width.

    Divided by their sum, but by no less than 1/2, so that steps fade to 0 on the rim of the whole.
    """
    weights = 1 - np.cos(np.pi / 2 * np.clip(masks, 0, 1))
    return weights / np.maximum(weights.sum(axis=2, keepdims=True), 0.5)


def signed_areas(uv: Float[np.ndarray, "n 2"], faces: Int[np.ndarray, "m 3"]) -> Float[np.ndarray, " m"]:
    """Of triangles in the image, square pixels; the sign says which way round they are."""
    b, c = uv[faces[:, 1]] - uv[faces[:, 0]], uv[faces[:, 2]] - uv[faces[:, 0]]
    return (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]) / 2


def grid_of(shape: tuple[int, ...]) -> Float[np.ndarray, "h w 2"]:
    """Every pixel's own place (x, y)."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    return np.stack([columns, rows], -1).astype(float)


def sampled(
    image: Float[np.ndarray, "h w *c"], points: Float[np.ndarray, "*p 2"], order: int = 1
) -> Float[np.ndarray, "*p c"]:
    """The image at points (x, y) in pixels; the border's value beyond it. NaN spreads to all that touch it."""
    where = [points[..., 1], points[..., 0]]
    flat = image.reshape(*image.shape[:2], -1)
    channels = [ndimage.map_coordinates(flat[..., c], where, order=order, mode="nearest") for c in range(flat.shape[2])]
    return np.stack(channels, axis=-1)
