"""The neutral face from a merged scan (Li et al. 2013, sec. 3): identity coefficients, then a shrink-wrap."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from ..faces.bundled import BundledFace
from ..landmarks.on_rig import IRISES, LandmarkMap, skin_faces
from ..mesh import (
    ClosestPoint,
    Mesh,
    adjacency,
    boundary_vertices,
    cotangent_laplacian,
    face_normals,
    mass,
    vertex_normals,
)
from ..transforms import Transform, rotation_from_vector


@dataclass(frozen=True)
class NeutralConfig:
    """The identity fit and the shrink-wrap."""

    rounds: int = 12
    """Rounds of closest points and solve in the identity fit."""
    reach: tuple[float, float] = (20.0, 4.0)
    """Farthest correspondence believed, mm, in the first round and in the last."""
    prior: float = 0.02
    """Weight of the squared identity coefficients (in standard deviations) against mean squared distance, mm^2."""
    landmarks: float = 0.02
    """Weight of a landmark's squared offset sideways to the line of sight, against the mean squared distance."""
    wrap: tuple[float, ...] = (40.0, 20.0, 10.0, 6.0)
    """Shrink-wrap: half wavelength below which detail of the scan is not followed, mm, round by round."""
    wrap_reach: float = 5.0
    """Farthest correspondence believed in the shrink-wrap, mm."""
    agree: float = 0.5
    """Least cosine between the two normals."""


@dataclass(frozen=True)
class NeutralResult:
    """A person's neutral face in the bundled topology."""

    mesh: Mesh
    """Face space, mm."""
    coefficients: Float[np.ndarray, " c"]
    """Identity coefficients, standard deviations."""
    T_scan_face: Transform
    fitted: float
    """Mean distance from the scan after the identity fit, mm."""
    wrapped: float
    """Mean distance from the scan after the shrink-wrap, mm."""


@dataclass(frozen=True)
class Target:
    """A scan made ready to be fitted to."""

    tree: ClosestPoint
    normals: Float[np.ndarray, "m 3"]
    border: Bool[np.ndarray, " m"]
    """Triangles on the scan's border, which stand for surface that was not seen."""


def target(scan: Mesh) -> Target:
    """Closest points, normals and border of a scan."""
    edge = np.zeros(len(scan.vertices), bool)
    edge[boundary_vertices(scan.faces)] = True
    return Target(ClosestPoint(scan), face_normals(scan.vertices, scan.faces), np.asarray(edge[scan.faces].any(1)))


def fit_neutral(
    face: BundledFace,
    landmarks: LandmarkMap,
    scan: Mesh,
    seen: Float[np.ndarray, "478 3"],
    eye: Float[np.ndarray, " 3"],
    config: NeutralConfig = NeutralConfig(),
) -> NeutralResult:
    """Fit the identity space with a rigid transform, then follow the scan's detail.

    Args:
        landmarks: where MediaPipe's landmarks are on the bundled face.
        scan: mm, roughly in face space.
        seen: the landmarks found on the scan, in its space; NaN where unknown.
        eye: where the camera was, in the scan's space; landmarks are known sideways to its line of sight alone.
    """
    goal = target(scan)
    coefficients, T_scan_face, fitted = fit_identity(face, landmarks, goal, seen, eye, config)
    shape = face.rig.neutral.vertices + face.identity.displacement(coefficients)
    mesh = face.rig.neutral.with_vertices(T_scan_face.apply(shape))
    wrapped, distance = shrink_wrap(mesh, face.regions["face"], goal, config)
    home = T_scan_face.inverse()
    return NeutralResult(mesh.with_vertices(home.apply(wrapped)), coefficients, T_scan_face, fitted, distance)


def fit_identity(face, landmarks, goal: Target, seen, eye, config: NeutralConfig):
    """Coefficients, T_scan_face and mean distance: Gauss-Newton on point-to-plane and landmark terms with a prior."""
    base, modes = face.rig.neutral.vertices, face.identity.modes
    use = np.flatnonzero(face.regions["face"] > 0.5)
    area = mass(base, face.rig.neutral.faces)[use]
    a, T, distance = np.zeros(len(modes)), Transform.identity(), np.inf
    spots = _landmark_modes(face, landmarks, seen)
    for reach in np.geomspace(*config.reach, config.rounds):
        shape = base + face.identity.displacement(a)
        points = T.apply(shape)
        normals = T.rotate(vertex_normals(shape, face.rig.neutral.faces))
        rows, right, distance = _surface_rows(points[use], normals[use], modes[:, use], T, area, goal, reach, config)
        more, offsets = _landmark_rows(spots, a, T, seen, eye, config)
        J, r = np.concatenate([rows, more]), np.concatenate([right, offsets])
        prior = np.r_[np.full(len(modes), config.prior / len(modes)), np.full(6, 1e-9)]
        change = np.linalg.solve(J.T @ J + np.diag(prior), J.T @ r - prior * np.r_[a, np.zeros(6)])
        a = a + change[: len(modes)]
        T = Transform(rotation_from_vector(change[-6:-3]), change[-3:]) @ T
    return a, T, distance


def _surface_rows(points, normals, modes, T, area, goal: Target, reach, config):
    """Point-to-plane to the scan (weights add up to 1), and the mean distance of what corresponds."""
    found = goal.tree.query(points)
    away = goal.normals[found.faces]
    good = (found.distances < reach) & ~goal.border[found.faces] & ((away * normals).sum(1) > config.agree)
    root = np.sqrt(area[good] / area[good].sum()) / (1 + (found.distances[good] / 4.0) ** 2)
    n, p = away[good], points[good]
    shapes = np.einsum("pd,kpd->pk", n @ T.rotation, modes[:, good])
    rows = np.concatenate([shapes, np.cross(p, n), n], 1) * root[:, None]
    return rows, ((found.points[good] - p) * n).sum(1) * root, float(found.distances[good].mean())


def _landmark_modes(face, landmarks, seen):
    """Neutral places (j, 3) and modes (c, j, 3) of the landmarks that are known on both sides, and which."""
    ids = np.flatnonzero(landmarks.known & np.isfinite(seen[:, 0]) & (np.arange(len(seen)) < IRISES.start))
    corners = face.rig.neutral.faces[landmarks.attachment.faces[ids]]
    weights = landmarks.attachment.barycentric[ids]
    rest = np.einsum("jcd,jc->jd", face.rig.neutral.vertices[corners], weights)
    return ids, rest, np.einsum("kjcd,jc->kjd", face.identity.modes[:, corners], weights)


def _landmark_rows(spots, a, T, seen, eye, config):
    """Landmarks, sideways to the lines of sight from `eye`: the 2D constraint in millimetres."""
    ids, rest, modes = spots
    points = T.apply(rest + np.tensordot(a, modes, axes=1))
    sight = seen[ids] - eye
    sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    H = np.eye(3) - sight[:, :, None] * sight[:, None, :]
    right = np.einsum("jab,jb->ja", H, seen[ids] - points)
    root = np.sqrt(config.landmarks / max(len(ids), 1)) / (1 + (right**2).sum(1) / 6.0**2)
    shapes = np.einsum("ad,kjd->jak", T.rotation, modes)
    turn = np.stack([np.cross(e, points) for e in np.eye(3)], -1)
    J = np.concatenate([shapes, turn, np.broadcast_to(np.eye(3), (len(ids), 3, 3))], 2)
    rows = np.einsum("jab,jbc->jac", H * root[:, None, None], J)
    return rows.reshape(-1, J.shape[2]), (right * root[:, None]).ravel()


def shrink_wrap(
    mesh: Mesh, mask: Float[np.ndarray, " n"], goal: Target, config: NeutralConfig = NeutralConfig()
) -> tuple[Float[np.ndarray, "n 3"], float]:
    """Draw the skin onto the scan, smoothly: vertices in the scan's space (mm), mean distance of what corresponds.

    Displacements d solve (W + s L'M^-1 L) d = W (foot - v): the foot of each vertex on the plane of its closest point,
    weighed by area and `mask`. Where nothing corresponds the skin follows its surroundings; eyeballs and teeth move
    with the skin nearest to them.
    """
    faces = mesh.faces[skin_faces(mesh)]
    skin = np.unique(faces)
    vertices = mesh.vertices.copy()
    L, area = cotangent_laplacian(mesh.vertices, faces), mass(mesh.vertices, faces)
    inverse = sp.diags(np.divide(1.0, area, out=np.zeros_like(area), where=area > 0))
    smooth = (L @ inverse @ L)[skin][:, skin]
    rest = area[skin] * 1e-4
    for wave in config.wrap:
        weight, offset, distance = _feet(vertices, faces, goal, mask, config)
        w = (area * weight)[skin]
        stiff = (wave / np.pi) ** 4
        matrix = sp.csc_matrix(sp.diags(w + rest) + stiff * smooth)
        vertices[skin] += splu(matrix).solve(w[:, None] * offset[skin])
    others = np.setdiff1d(np.arange(len(vertices)), skin)
    return _follow(mesh, vertices, skin, others), distance


def _feet(vertices, faces, goal: Target, mask, config):
    """Weight (n,), offset to the foot on the closest point's plane (n, 3), mean distance of what counts."""
    normals = vertex_normals(vertices, faces)
    found = goal.tree.query(vertices)
    away = goal.normals[found.faces]
    good = (found.distances < config.wrap_reach) & ~goal.border[found.faces]
    good &= ((away * normals).sum(1) > config.agree) & (mask > 0)
    gap = ((found.points - vertices) * away).sum(1, keepdims=True)
    return mask * good, gap * away, float(found.distances[good].mean())


def _follow(mesh: Mesh, moved: np.ndarray, skin: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Parts that are not skin, each shifted by the mean displacement of the 60 skin vertices nearest to it."""
    _, label = connected_components(adjacency(mesh.faces, len(mesh.vertices)), directed=False)
    out, shift = moved.copy(), moved - mesh.vertices
    for part in np.unique(label[others]):
        members = others[label[others] == part]
        squared = ((mesh.vertices[skin] - mesh.vertices[members].mean(0)) ** 2).sum(1)
        nearest = skin[np.argsort(squared)[:60]]
        out[members] = mesh.vertices[members] + shift[nearest].mean(0)
    return out
