"""Rigid head motion by projective point-to-plane ICP (Li et al. 2013, sec. 4.1; Rusinkiewicz and Levoy 2001)."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32, Int

from .._kernels import icp, track
from ..register.rigid_icp import closest_point_rounds, pose_step
from ..transforms import Transform, vector_from_rotation
from .preprocess_frame import FrameObservation

LEVER = 100.0
"""Millimetres: turns are counted in 1/100 radian, so that they and shifts are about as large."""


@dataclass(frozen=True)
class RigidConfig:
    """Rigid ICP."""

    reach: float = 25.0
    """DepthCorrespondences farther than this are pruned, mm."""
    enough: float = 3.0
    """ICP ends when the mean distance of what is left is below this, mm. One step at least is made."""
    iterations: int = 12
    """After so many steps above `enough` the head is lost."""
    least_cosine: float = 0.3
    """Least cosine between the model's and the depth's normal, and of the model's to the line of sight."""
    robust_scale_mm: float = 6.0
    """Residuals much above this lose weight, mm: what moves by itself does not turn the head. Large = plain."""
    step: int = 2
    """Pixels over which a depth normal is measured."""
    least: float = 0.25
    """The head is lost when less than this share of the front's area corresponds."""


@dataclass(frozen=True)
class RigidResult:
    """Where the head is."""

    T_camera_face: Transform
    error: float
    """Mean point-to-plane distance of what was not pruned, mm, before the last step."""
    covered: float
    """Share of the front's area that corresponds, 0..1."""
    converged: bool
    iterations: int


@dataclass(frozen=True)
class DepthCorrespondences:
    """The front's vertices in camera space and the depth points that they fall on."""

    points: Float32[np.ndarray, "f 3"]
    """The vertices, mm."""
    found: Float32[np.ndarray, "f 3"]
    """p: the depth pixel's points, mm."""
    plane: Float32[np.ndarray, "f 3"]
    """n: unit normals of the depth there."""
    weight: Float32[np.ndarray, " f"]
    """Cosine between the plane and the line of sight; 0 = pruned."""


def correspond(
    vertices: Float32[np.ndarray, "f 3"],
    normals: Float32[np.ndarray, "f 3"],
    T_camera_face: Transform,
    observation: FrameObservation,
    config: RigidConfig,
) -> DepthCorrespondences:
    """Project the front's vertices (face space, mm) into the depth image and prune.

    Args:
        normals: of the vertices, or of a shape near to them: they serve to prune.
    """
    points = track.place(vertices, T_camera_face.rotation, T_camera_face.translation)
    normals = track.place(normals, T_camera_face.rotation, np.zeros(3))
    found = icp.correspond(
        points, normals, observation.depth, observation.intrinsics, np.float32(config.reach),
        np.float32(config.least_cosine), config.step,
    )  # fmt: skip
    return DepthCorrespondences(points, *found)


def align(
    vertices: Float32[np.ndarray, "f 3"],
    faces: Int[np.ndarray, "m 3"],
    share: Float32[np.ndarray, " f"],
    T_camera_face: Transform,
    observation: FrameObservation,
    config: RigidConfig = RigidConfig(),
) -> RigidResult:
    """Move the model of the last frame, as it is, onto this frame's depth."""
    normals = track.vertex_normals(vertices, faces)

    def one_round(now: RigidResult) -> tuple[RigidResult, bool]:
        match = correspond(vertices, normals, now.T_camera_face, observation, config)
        covered = float(share[match.weight > 0].sum())
        if covered < config.least:
            return replace(now, covered=covered), True
        centre = match.points.mean(0, dtype=np.float64)
        A, b, error, _ = icp.rigid_system(
            match.points, match.found, match.plane, match.weight * share, centre, config.robust_scale_mm
        )
        T = moved(now.T_camera_face, pose_step(A, b), centre)
        return replace(now, T_camera_face=T, error=error, covered=covered), error < config.enough

    begun = RigidResult(T_camera_face, np.inf, 0.0, False, 0)
    walked = closest_point_rounds(begun, one_round, config.iterations)
    near = walked.settled and walked.state.covered >= config.least
    return replace(walked.state, converged=near, iterations=walked.done)


def moved(T_camera_face: Transform, motion: Float[np.ndarray, " 6"], centre: Float[np.ndarray, " 3"]) -> Transform:
    """`T_camera_face` followed by a turn (radians) about `centre` (mm, camera space) and a shift (mm)."""
    return Transform(*track.turned(T_camera_face.rotation, T_camera_face.translation, motion, centre))


def damp_pose(
    points: Float[np.ndarray, "p 3"], centre: Float[np.ndarray, " 3"], before: Transform, now: Transform, size: float
) -> Transform:
    """`now`, drawn back towards `before` by size^2 / (size^2 + d^2), d the motion of `points` between them, mm rms.

    The turn between the two is about `centre`; both, and `points`, are in face space, mm.
    """
    squared = float(((now.apply(points) - before.apply(points)) ** 2).sum(1).mean())
    part = squared / (squared + size**2) if squared else 1.0
    turn = vector_from_rotation(now.rotation @ before.rotation.T)
    here = before.apply(centre[None])[0]
    there = now.apply(centre[None])[0]
    return moved(before, part * np.concatenate([turn, there - here]), here)
