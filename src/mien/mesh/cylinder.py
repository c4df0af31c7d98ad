"""A face unrolled from a cylinder round the head, one-to-one: image space for matching wrinkles."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from jaxtyping import Bool, Float, Int

from mien.errors import BadInput

from .mesh import Mesh
from .operators import adjacency, face_areas, mean_edge_length
from .raster import SurfaceImage

MARGIN = 2
"""Pixels left free all round."""
REACHES = (3.0, 6.0, 12.0, 24.0, 48.0)
"""Millimetres round a fold that are laid out anew, tried in turn until the fold is gone."""
SHARPENINGS = 12
"""How often, for one reach, folds are forbidden more sharply before it is given up."""


WIDEST = 2.0
"""Radians to either side of the front that a face may take round its cylinder: past the ears."""
STEPS = 20
"""Places that are tried for the axis."""


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder in face space, millimetres."""

    x: float
    z: float
    """Where the axis, parallel to +Y, stands."""
    radius: float

    def unroll(self, points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 2"]:
        """Arc length from +Z towards +X, and height y, mm."""
        angle = np.arctan2(points[:, 0] - self.x, points[:, 2] - self.z)
        return np.stack([self.radius * angle, points[:, 1]], 1)


@dataclass(frozen=True)
class Unrolled:
    """A mesh laid out in an image as seen from outside: the subject's left is on the right, up is up."""

    uv: Float[np.ndarray, "n 2"]
    """Vertices in pixels (x, y), centres at integers, y down."""
    faces: Int[np.ndarray, "m 3"]
    shape: tuple[int, int]
    """Height and width of the image that holds it."""
    pixel_mm: float
    """Side of a pixel on the cylinder, mm."""
    cylinder: Cylinder
    folded: int
    """Triangles that the cylinder alone turns over."""
    squeezed: int
    """Further triangles that it leaves less than the least area."""
    moved: int
    """Vertices moved off their place on the cylinder to mend that."""

    @property
    def overlap(self) -> float:
        """Share of the surface's area in the image that lies over other surface; about 0 if one-to-one."""
        corners = self.uv[self.faces]
        b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = np.abs(b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]).sum() / 2
        return max(0.0, 1 - float(self.image().mask.sum() / max(area, 1.0)))

    def image(self) -> SurfaceImage:
        """The layout as an image to draw into."""
        return SurfaceImage(self.uv, self.faces, self.shape)


def fit_cylinder(mesh: Mesh) -> Cylinder:
    """The upright cylinder closest to a face (+Y up, +Z out), least squares over the surface's area.

    If some of the surface lies behind its axis, as the underside of a chin may, the axis goes back until none does.
    """
    areas = face_areas(mesh.vertices, mesh.faces)
    middle = mesh.vertices[mesh.faces].mean(1)
    x, z, weight = middle[:, 0], middle[:, 2], np.sqrt(areas)
    terms = np.stack([2 * x, 2 * z, np.ones_like(x)], 1) * weight[:, None]
    cx, fitted, _ = np.linalg.lstsq(terms, (x * x + z * z) * weight, rcond=None)[0]
    used = mesh.vertices[np.unique(mesh.faces)]
    for cz in np.linspace(fitted, min(fitted, used[:, 2].min()), STEPS):
        if np.abs(np.arctan2(used[:, 0] - cx, used[:, 2] - cz)).max() < WIDEST:
            break
    return Cylinder(float(cx), float(cz), float(np.average(np.hypot(x - cx, z - cz), weights=areas)))


def unroll_face(
    mesh: Mesh, pixel_mm: float = 0.5, cylinder: Cylinder | None = None, least_area: float = 0.05
) -> Unrolled:
    """Lay a face out in an image by cylindrical projection, made one-to-one (Huang et al. 2011, sec. 6.2).

    Plain projection folds under the nose, the chin and the lips. There, and where a triangle keeps less than
    `least_area` of its area, the vertices round the fold are laid out anew: as close to their shape on the surface as
    they can be with every triangle turned the right way (Garanzha et al. 2021). The rest stays where the cylinder puts
    it. That forbids folds; layers that lie over each other, such as an eyeball and its lids, show up as `overlap`.

    Raises:
        BadInput: a mesh that goes all the way round the cylinder, or a fold that cannot be undone.
    """
    if not pixel_mm > 0:
        raise BadInput(f"unroll: pixel_mm is {pixel_mm}; give a positive side of a pixel")
    cylinder = cylinder or fit_cylinder(mesh)
    flat = cylinder.unroll(mesh.vertices)
    _check_open(mesh, flat, cylinder)
    shares = _area_shares(mesh, flat)
    uv = _unfold(mesh, flat, least_area)
    used = uv[np.unique(mesh.faces)]
    low, high = used.min(0), used.max(0)
    pixels = np.stack([uv[:, 0] - low[0], high[1] - uv[:, 1]], 1) / pixel_mm + MARGIN
    width, height = np.ceil((high - low) / pixel_mm).astype(int) + 1 + 2 * MARGIN
    folded = shares <= 0
    return Unrolled(
        uv=pixels,
        faces=mesh.faces,
        shape=(int(height), int(width)),
        pixel_mm=pixel_mm,
        cylinder=cylinder,
        folded=int(folded.sum()),
        squeezed=int((shares < least_area).sum() - folded.sum()),
        moved=int((uv != flat).any(1).sum()),
    )


def _check_open(mesh: Mesh, flat: np.ndarray, cylinder: Cylinder) -> None:
    across = np.ptp(flat[mesh.faces, 0], axis=1).max(initial=0.0)
    if across > np.pi * cylinder.radius:
        raise BadInput("unroll: the mesh goes all round its cylinder; crop it to the face, open at the back")


def _area_shares(mesh: Mesh, flat: np.ndarray) -> Float[np.ndarray, " m"]:
    """Signed area laid out, as a share of the triangle's own; 1 for one of no area."""
    a, b, c = (flat[mesh.faces[:, i]] for i in range(3))
    signed = ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])) / 2
    own = face_areas(mesh.vertices, mesh.faces)
    return np.where(own > 1e-12, signed / np.maximum(own, 1e-12), 1.0)


def _unfold(mesh: Mesh, flat: np.ndarray, least_area: float) -> Float[np.ndarray, "n 2"]:
    """The layout with every triangle turned the right way, changed round folds only."""
    A = adjacency(mesh.faces, len(flat))
    uv = flat.copy()
    edge = mean_edge_length(mesh.vertices, mesh.faces)
    for reach in REACHES:
        bad = _area_shares(mesh, uv) < least_area
        if not bad.any():
            return uv
        near = np.zeros(len(flat), bool)
        near[mesh.faces[bad]] = True
        for _ in range(max(2, round(reach / edge))):
            near = near | (A @ near.astype(float) > 0)
        uv = _relay(mesh, uv, near)
    if (_area_shares(mesh, uv) <= 0).any():
        left = int((_area_shares(mesh, uv) <= 0).sum())
        raise BadInput(
            f"unroll: {left} triangles stay folded; crop the mesh to one open piece, without what lies behind"
        )
    return uv


def _relay(mesh: Mesh, uv: np.ndarray, free: Bool[np.ndarray, " n"]) -> Float[np.ndarray, "n 2"]:
    """Lay the free vertices out anew: least distortion of their triangles, folds forbidden ever more sharply."""
    own = face_areas(mesh.vertices, mesh.faces)
    faces = mesh.faces[free[mesh.faces].any(1) & (own > 1e-12)]
    gradients, areas = _surface_gradients(mesh.vertices, faces)
    index = np.flatnonzero(free)
    uv = uv.copy()
    stiffness = _stiffness(faces, gradients, areas, len(uv))
    factor = spl.splu((stiffness[index][:, index] + 1e-6 * sp.identity(len(index))).tocsc())

    def energy(x: np.ndarray, epsilon: float) -> tuple[float, np.ndarray]:
        uv[index] = x
        value, slope = _distortion(uv, faces, gradients, areas, epsilon)
        return value, slope[index]

    uv[index] = _evened(mesh, uv, index)
    least = -np.inf
    for _ in range(SHARPENINGS):
        before, least = least, float(np.linalg.det(np.einsum("mcd,mce->mde", uv[faces], gradients)).min())
        epsilon = np.sqrt(1e-6 + 0.04 * min(least, 0.0) ** 2)
        uv[index] = descend(partial(energy, epsilon=epsilon), uv[index], factor.solve)
        if least > 0 or (before > -np.inf and least < before + 0.02 * abs(before)):
            break
    return uv


def _evened(mesh: Mesh, uv: np.ndarray, index: Int[np.ndarray, " k"]) -> Float[np.ndarray, "k 2"]:
    """Each of the vertices `index` in the middle of its neighbours (Tutte 1963): nearly free of folds to start from."""
    A = adjacency(mesh.faces, len(uv))[index]
    fixed = np.ones(len(uv))
    fixed[index] = 0
    L = sp.diags(np.asarray(A.sum(1)).ravel()) - A[:, index] + 1e-9 * sp.identity(len(index))
    return spl.splu(L.tocsc()).solve(A @ (uv * fixed[:, None]) + 1e-9 * uv[index])


def descend(
    energy: Callable[[np.ndarray], tuple[float, np.ndarray]],
    x: Float[np.ndarray, "k d"],
    precondition: Callable[[np.ndarray], np.ndarray],
    steps: int = 60,
    memory: int = 8,
) -> Float[np.ndarray, "k d"]:
    """A minimum of `energy`, which gives value and gradient: L-BFGS with `precondition` for the inverse Hessian.

    With the Laplacian's inverse a mesh energy takes tens of steps, however fine the mesh (Zhu, Bridson, Kaufman 2018).
    """
    value, slope = energy(x)
    pairs: deque[tuple[np.ndarray, np.ndarray]] = deque(maxlen=memory)
    step = 0.5
    for _ in range(steps):
        direction = -_inverse_hessian(slope, pairs, precondition)
        descent = float((direction * slope).sum())
        if descent > -1e-9 * abs(value):
            break
        step = min(1.0, 2 * step)
        while step > 1e-6:
            moved, moved_slope = energy(x + step * direction)
            if moved <= value + 1e-4 * step * descent:
                break
            step *= 0.5
        else:
            break
        if (step * direction * (moved_slope - slope)).sum() > 0:
            pairs.append((step * direction, moved_slope - slope))
        x, value, slope = x + step * direction, moved, moved_slope
    return x


def _inverse_hessian(slope: np.ndarray, pairs: deque, precondition: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The two-loop recursion of L-BFGS."""
    q, shares = slope.copy(), []
    for s, y in reversed(pairs):
        shares.append((s * q).sum() / (s * y).sum())
        q -= shares[-1] * y
    q = precondition(q)
    for (s, y), share in zip(pairs, reversed(shares), strict=True):
        q += (share - (y * q).sum() / (s * y).sum()) * s
    return q


def _stiffness(faces: np.ndarray, gradients: np.ndarray, areas: np.ndarray, n: int) -> sp.csr_matrix:
    """The triangles' Laplacian (n, n)."""
    local = np.einsum("m,mae,mbe->mab", areas, gradients, gradients)
    rows, columns = np.repeat(faces, 3, axis=1).ravel(), np.tile(faces, (1, 3)).ravel()
    return sp.csr_matrix((local.ravel(), (rows, columns)), shape=(n, n))


def _surface_gradients(
    vertices: Float[np.ndarray, "n 3"], faces: Int[np.ndarray, "m 3"]
) -> tuple[Float[np.ndarray, "m 3 2"], Float[np.ndarray, " m"]]:
    """Gradients of the corners' hat functions in each triangle's own plane, 1/mm, and its area."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    length = np.linalg.norm(b - a, axis=1)
    ex = (b - a) / length[:, None]
    cx = ((c - a) * ex).sum(1)
    cy = np.linalg.norm(c - a - cx[:, None] * ex, axis=1)
    gb = np.stack([1 / length, -cx / (length * cy)], 1)
    gc = np.stack([np.zeros_like(cy), 1 / cy], 1)
    return np.stack([-gb - gc, gb, gc], 1), length * cy / 2


def _distortion(
    uv: np.ndarray, faces: np.ndarray, gradients: np.ndarray, areas: np.ndarray, epsilon: float
) -> tuple[float, Float[np.ndarray, "n 2"]]:
    """Shape and area distortion over the triangles and its gradient (Garanzha et al. 2021, eq. 3).

    With J the triangle's map and D its determinant: (|J|^2 + D^2 + 1) / chi, chi = (D + sqrt(epsilon^2 + D^2)) / 2,
    which is least (4) for a rigid map, and grows without bound as a triangle folds when epsilon goes to 0.
    """
    J = np.einsum("mcd,mce->mde", uv[faces], gradients)
    D = J[:, 0, 0] * J[:, 1, 1] - J[:, 0, 1] * J[:, 1, 0]
    root = np.sqrt(epsilon**2 + D * D)
    chi = np.where(D > 0, (D + root) / 2, epsilon**2 / (2 * (root - np.minimum(D, 0))))
    top = (J * J).sum((1, 2)) + D * D + 1
    cofactor = np.stack([np.stack([J[:, 1, 1], -J[:, 1, 0]], 1), np.stack([-J[:, 0, 1], J[:, 0, 0]], 1)], 1)
    by_D = 2 * D / chi - top / chi**2 * (chi / root)
    slope = 2 * J / chi[:, None, None] + by_D[:, None, None] * cofactor
    corner = np.einsum("m,mde,mce->mcd", areas, slope, gradients)
    total = np.stack([np.bincount(faces.ravel(), corner[..., d].ravel(), minlength=len(uv)) for d in range(2)], 1)
    return float((areas * top / chi).sum()), total
