"""Rigid and similarity transforms, single or in batches. A name reads target first: `T_camera_face`."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from .one_line import one_line


@dataclass(frozen=True)
class Transform:
    """x -> scale * rotation @ x + translation; leading axes are a batch (one transform a frame)."""

    rotation: Float[np.ndarray, "*batch 3 3"]
    """Orthonormal, right-handed."""
    translation: Float[np.ndarray, "*batch 3"]
    """Millimetres in the target frame."""
    scale: float = 1.0
    """1 for a rigid transform."""

    def __repr__(self) -> str:
        batch = self.rotation.shape[:-2]
        if batch:
            return one_line(self, "batch of " + " x ".join(map(str, batch)))
        cosine = np.clip((np.trace(self.rotation) - 1) / 2, -1, 1)
        moved = ", ".join(f"{x:.1f}" for x in self.translation)
        scale = "" if self.scale == 1 else f"scale {self.scale:.4g}"
        return one_line(self, f"turn {np.degrees(np.arccos(cosine)):.1f} degrees", f"move ({moved}) mm", scale)

    @staticmethod
    def identity(*batch: int) -> "Transform":
        """The transform that does nothing, repeated over `batch`."""
        return Transform(np.broadcast_to(np.eye(3), (*batch, 3, 3)).copy(), np.zeros((*batch, 3)))

    def apply(self, points: Float[np.ndarray, "*batch n 3"]) -> Float[np.ndarray, "*batch n 3"]:
        """Transform points (..., n, 3); a batched transform meets points frame by frame."""
        rotated = points @ np.swapaxes(self.rotation, -1, -2)
        return self.scale * rotated + self.translation[..., None, :]

    def rotate(self, vectors: Float[np.ndarray, "*batch n 3"]) -> Float[np.ndarray, "*batch n 3"]:
        """Rotate directions (normals); neither scale nor translation touch them."""
        return vectors @ np.swapaxes(self.rotation, -1, -2)

    def inverse(self) -> "Transform":
        """T_a_b -> T_b_a."""
        back = np.swapaxes(self.rotation, -1, -2)
        return Transform(back, -(back @ self.translation[..., None])[..., 0] / self.scale, 1.0 / self.scale)

    def __matmul__(self, other: "Transform") -> "Transform":
        """T_a_b @ T_b_c = T_a_c."""
        moved = self.scale * (self.rotation @ other.translation[..., None])[..., 0] + self.translation
        return Transform(self.rotation @ other.rotation, moved, self.scale * other.scale)

    def __getitem__(self, frame) -> "Transform":
        """One frame, or a slice of frames, of a batched transform."""
        return Transform(self.rotation[frame], self.translation[frame], self.scale)

    def __len__(self) -> int:
        return len(self.rotation)


def stacked(transforms: Sequence[Transform]) -> Transform:
    """Single rigid transforms as one batch."""
    return Transform(np.stack([T.rotation for T in transforms]), np.stack([T.translation for T in transforms]))


def rotation_from_vector(vectors: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Rodrigues: axis times angle in radians -> rotation matrix, batched."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    K = skew(vectors)
    small = angle < 1e-8
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(safe)) / safe**2)
    return np.eye(3) + a * K + b * (K @ K)


def rotation_looking_along(forward: Float[np.ndarray, " 3"]) -> Float[np.ndarray, "3 3"]:
    """World -> camera rotation of a camera that looks along a unit vector, with +Y (else +Z) up in its picture."""
    up = np.array([0.0, 1, 0]) if abs(forward[1]) < 0.9 else np.array([0.0, 0, 1])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def vector_from_rotation(rotations: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 3"]:
    """Rotation matrix -> axis times angle in radians, the inverse of `rotation_from_vector`, batched."""
    flat = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_rotvec()
    return flat.reshape(rotations.shape[:-1])


def skew(vectors: Float[np.ndarray, "*batch 3"]) -> Float[np.ndarray, "*batch 3 3"]:
    """The matrix K with K @ x = vector x x (cross product), batched."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    o = np.zeros_like(x)
    return np.stack([np.stack([o, -z, y], -1), np.stack([z, o, -x], -1), np.stack([-y, x, o], -1)], -2)


def quaternions_from_rotations(rotations: Float[np.ndarray, "*batch 3 3"]) -> Float[np.ndarray, "*batch 4"]:
    """Unit quaternions (x, y, z, w), neighbours in a sequence on the same hemisphere (no sign jumps)."""
    q = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_quat()
    if len(q) > 1:
        flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
        q[1:] *= np.cumprod(flips)[:, None]
    return q.reshape(*rotations.shape[:-2], 4)


def rotations_from_quaternions(quaternions: Float[np.ndarray, "*batch 4"]) -> Float[np.ndarray, "*batch 3 3"]:
    """Unit quaternions (x, y, z, w) -> rotation matrices."""
    return Rotation.from_quat(quaternions.reshape(-1, 4)).as_matrix().reshape(*quaternions.shape[:-1], 3, 3)
