"""The photometric term (past the paper): the skin goes on showing what it showed while it was first tracked.

Depth says nothing of motion along the skin, and landmarks err by a millimetre; brows, lips, nostrils and moles are seen
in the picture to a fraction of a pixel. Every vertex keeps what it showed in the first frames (`Reference`), and a
Gauss-Newton row asks that it shows the same now. Light that changes slowly over the face, as when the head turns, is
divided out: what is compared is contrast, the picture over its own mean round about. How far that holds for this skin
and this light the first frames tell: a vertex counts the less, the more it varies there.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Float32, UInt8

from ..._kernels import track, track_photo
from ...transforms import Transform

DARK = 8.0
"""Grey levels, of 255, added to the mean that contrast is taken by: in the dark it is noise."""

REGULAR = 1e-9
"""Of the mean diagonal, added to a pose's equations: too little is seen at times to tell one."""


@dataclass(frozen=True)
class PhotometricConfig:
    """The photometric term."""

    weight: float = 8000.0
    """Weight of a squared difference of contrast, beside squared millimetres of depth; 0 = none."""
    noise: float = 0.004
    """What a vertex shows may vary by so much in the first frames and still count half. Where light wanders over the
    skin as the head turns, or what is seen is badly told, it varies by several times that."""
    scale: float = 0.1
    """Differences of contrast much above this lose weight: what has come out from behind a lip was not there before."""
    smooth: tuple[int, ...] = (2, 1)
    """Half widths of the window that the picture is smoothed by, pixels, one a round of the fit: coarse to fine."""
    around: int = 4
    """Half width of the window whose mean contrast is taken by, pixels: moles and edges pass, shaded folds do not."""
    frames: int = 20
    """Frames over which the reference is averaged."""
    least_cosine: float = 0.35
    """Least cosine of a vertex's normal to the line of sight."""
    head: float = 1.0
    """How far the picture's say in the head's pose counts, 0..1; 0: it tells of the shapes what no pose explains."""


@dataclass(frozen=True)
class Reference:
    """What each vertex of the front showed in the first frames, at each smoothing."""

    contrast: tuple[Float32[np.ndarray, " f"], ...]
    square: tuple[Float32[np.ndarray, " f"], ...]
    """Mean square of the same."""
    count: Float32[np.ndarray, " f"]
    """Frames it was seen in."""
    frames: int
    """Frames that were learnt from."""

    def weight(self, level: int, config: PhotometricConfig) -> Float32[np.ndarray, " f"]:
        """How far each vertex's reference may be trusted, 0..1: where it was always seen and showed the same."""
        often = np.minimum(self.count / np.float32(max(min(config.frames, self.frames), 1)), np.float32(1))
        variance = np.maximum(self.square[level] - self.contrast[level] ** 2, np.float32(0))
        noise = np.float32(config.noise**2)
        return often * noise / (noise + variance)


def no_reference(vertices: int, config: PhotometricConfig) -> Reference:
    """Nothing seen yet."""
    zeros = np.zeros(vertices, np.float32)
    levels = tuple(zeros for _ in set(config.smooth))
    return Reference(levels, levels, zeros, 0)


def contrasts(color: UInt8[np.ndarray, "h w 3"], config: PhotometricConfig) -> tuple[Float32[np.ndarray, "h w"], ...]:
    """The picture over its mean round about, less 1: one image a smoothing, from the finest."""
    grey = track_photo.grey(color)
    mean = track_photo.box(track_photo.box(grey, config.around), config.around // 2) + np.float32(DARK)
    return tuple(track_photo.box(grey, radius) / mean - np.float32(1) for radius in sorted(set(config.smooth)))


def photometric_match(points, normals, image, intrinsics, reference, valid, config: PhotometricConfig):
    """Planes that vertices should lie on to show `reference`: found, plane, weight, shown (`_kernels.track_photo`)."""
    least = np.float32(config.least_cosine)
    return track_photo.sample_plane(points, normals, image, intrinsics, reference, valid, least)


def learn_reference(
    reference: Reference,
    images: tuple[Float32[np.ndarray, "h w"], ...] | None,
    intrinsics,
    vertices: Float32[np.ndarray, "f 3"],
    faces,
    seen: Float32[np.ndarray, " f"] | None,
    T_camera_face: Transform,
    config: PhotometricConfig,
) -> Reference:
    """Average in what the tracked face shows, while there are few frames."""
    if images is None or reference.frames >= config.frames:
        return reference
    points = track.place(vertices, T_camera_face.rotation, T_camera_face.translation)
    normals = track.vertex_normals(points, faces)
    ones = np.ones(len(points), np.float32) if seen is None else (seen > 0).astype(np.float32)
    contrast, square = [], []
    for image, old, old_square in zip(images, reference.contrast, reference.square, strict=True):
        _, _, weight, shown = photometric_match(points, normals, image, intrinsics, old, ones, config)
        there = (weight > 0).astype(np.float32)
        count = reference.count + there
        contrast.append(old + there * (shown - old) / np.maximum(count, 1))
        square.append(old_square + there * (shown**2 - old_square) / np.maximum(count, 1))
    return Reference(tuple(contrast), tuple(square), count, reference.frames + 1)


def with_less_head(
    A: Float[np.ndarray, "c c"], b: Float[np.ndarray, " c"], share: float
) -> tuple[Float[np.ndarray, "c c"], Float[np.ndarray, " c"]]:
    """Normal equations of shapes and, in the last six rows, the head's pose, whose say counts `share`.

    At 0 the pose is eliminated (Schur complement): what is left is asked of the shapes, whatever the pose. Without
    depth skin that slips or is shaded anew would be taken for a head that turns and comes nearer.
    """
    if share == 1.0 or not A.any():
        return A, b
    k = len(b) - 6
    pose = A[k:, k:] + REGULAR * np.trace(A[k:, k:]) / 6 * np.eye(6)
    gain = np.linalg.solve(pose, A[k:, :k]).T
    alone, right = np.zeros_like(A), np.zeros_like(b)
    alone[:k, :k] = A[:k, :k] - gain @ A[k:, :k]
    right[:k] = b[:k] - gain @ b[k:]
    return share * A + (1 - share) * alone, share * b + (1 - share) * right
