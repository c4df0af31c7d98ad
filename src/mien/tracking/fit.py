"""The fit of the initial blendshapes (Li et al. 2013, sec. 4.2): one function a term, one box-constrained solve.

A term is rows J and a right-hand side r, both times the root of its weight: J @ z should be r, where z is the change of
the k coefficients, then a turn of the head (in 1/100 rad about the front's centre) and a shift (mm). Feature terms
return them; the depth term, of thousands of rows, returns their normal equations J'J and J'r at once.

Units. The paper's w = 5e-5 weighs squared c_F, which carries the focal length: with its Kinect (f = 525 pixels) that is
w f^2 = 13.8 on the plane z = 1, where c_F is in millimetres at the face: one feature counts like 14 depth points,
whatever the camera. The depth term counts as much as the paper's 3,480 points, shared out by area, whatever the mesh.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32

from .._kernels import icp, track, track_fit
from ..register.rigid_icp import pose_step
from ..transforms import Transform
from .model import POINTS, TrackingModel
from .preprocess_frame import FrameObservation
from .reproject_weights import box_solve
from .rigid import LEVER, DepthCorrespondences, RigidConfig, correspond, moved
from .terms.features import feature_rows, normal_equations
from .terms.fit_config import BlendshapeFitConfig
from .terms.photometric import PhotometricConfig, Reference, photometric_match, with_less_head
from .terms.weight_prior import add_priors

System = tuple[np.ndarray, np.ndarray]
"""J'J (k + 6, k + 6) and J'r (k + 6,)."""

POSE_RIDGE = 1e-6
"""Weight of the pose's change, of the mean diagonal: keeps the solve definite where nothing speaks of the pose."""


@dataclass(frozen=True)
class FitResult:
    """What a frame's blendshape fit gave."""

    weights: Float[np.ndarray, " k"]
    """x, each in 0..1."""
    T_camera_face: Transform
    error: float
    """Mean point-to-plane distance, mm, before the last round's solve; NaN without depth."""
    covered: float
    """Share of the front's area that corresponds."""
    breach: float = 0.0
    """Largest breach of the optimality conditions that a round's solve was left with, relative; 0 = exact."""
    seen: Float32[np.ndarray, " f"] | None = None
    """Weight of each vertex's correspondence in the last round; None without depth."""


def fit_blendshapes(
    model: TrackingModel,
    observation: FrameObservation,
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    config: BlendshapeFitConfig = BlendshapeFitConfig(),
    rigid: RigidConfig = RigidConfig(),
    reference: Reference | None = None,
    pose_weights: Float32[np.ndarray, " f"] | None = None,
) -> FitResult:
    """Alternate correspondences and box-constrained solves, from the last frame's weights and this frame's pose.

    Args:
        pose_weights: what each vertex counts when the pose is measured anew; its share of the area if not given.
    """
    x, error, covered, breach = weights, np.nan, 0.0, 0.0
    vertices = model.blend(x)
    normals = track.vertex_normals(vertices, model.faces)
    match = None
    for done in range(config.rounds):
        centre = T_camera_face.apply(model.centre[None])[0]
        features = feature_rows(model, observation, x, T_camera_face, centre, config)
        A, b = normal_equations(features, model.shapes)
        if observation.depth is not None:
            match = correspond(vertices, normals, T_camera_face, observation, rigid)
            (gram, product), error, covered = depth_term(model, match, T_camera_face, centre, config)
            A, b = A + gram, b + product
        look = appearance(observation, match, vertices, normals, T_camera_face, reference, done, config.photometric)
        if look is not None:
            gram, product = photometric_term(model, look, T_camera_face, centre, config)
            A, b = A + gram, b + product
        add_priors(A, b, x, weights, observation.landmark_scores, model.prior, model.size, config)
        change, left = _solve(A, b, x, config.pose)
        breach = max(breach, left)
        x = np.clip(x + change[: model.shapes], 0.0, 1.0)
        vertices = model.blend(x)
        motion = change[model.shapes :].copy()
        motion[:3] /= LEVER
        T_camera_face = moved(T_camera_face, motion, centre)
        if match is not None and config.refine_pose_mm:
            says = model.share if pose_weights is None else pose_weights
            T_camera_face = refine_pose(model, vertices, match, T_camera_face, says, config)
    return FitResult(x, T_camera_face, error, covered, breach, None if match is None else match.weight)


def refine_pose(
    model: TrackingModel,
    vertices: Float32[np.ndarray, "f 3"],
    match: DepthCorrespondences,
    T_camera_face: Transform,
    pose_weights: Float32[np.ndarray, " f"],
    config: BlendshapeFitConfig,
) -> Transform:
    """One ICP step of the fitted face, each vertex with its weight."""
    points = track.place(vertices, T_camera_face.rotation, T_camera_face.translation)
    centre = T_camera_face.apply(model.centre[None])[0]
    weight = match.weight * pose_weights
    A, b, _, _ = icp.rigid_system(points, match.found, match.plane, weight, centre, config.refine_pose_mm)
    return moved(T_camera_face, pose_step(A, b), centre)


def appearance(
    observation: FrameObservation,
    match: DepthCorrespondences | None,
    vertices: Float32[np.ndarray, "f 3"],
    normals: Float32[np.ndarray, "f 3"],
    T_camera_face: Transform,
    reference: Reference | None,
    done: int,
    config: PhotometricConfig,
) -> DepthCorrespondences | None:
    """Planes that the vertices should lie on to show what they used to; None where nothing is known of that."""
    if observation.contrast is None or reference is None or not reference.frames or not config.weight:
        return None
    level = sorted(set(config.smooth)).index(config.smooth[min(done, len(config.smooth) - 1)])
    points = track.place(vertices, T_camera_face.rotation, T_camera_face.translation)
    turned = track.place(normals, T_camera_face.rotation, np.zeros(3))
    valid = reference.weight(level, config)
    if match is not None:
        valid = valid * (match.weight > 0)
    found, plane, weight, _ = photometric_match(
        points, turned, observation.contrast[level], observation.intrinsics, reference.contrast[level], valid, config
    )
    return DepthCorrespondences(points, found, plane, weight)


def photometric_term(
    model: TrackingModel, look: DepthCorrespondences, T_camera_face: Transform, centre, config: BlendshapeFitConfig
) -> System:
    """Contrast as remembered, for every vertex that is seen: the normal equations, the pose's say as configured."""
    packed, c = model.packed_basis, config.photometric
    A, b, _, _ = track_fit.plane_system(
        packed.order, packed.columns, packed.values, model.shapes, T_camera_face.rotation,
        look.points, look.found, look.plane, look.weight, model.share * np.float32(POINTS * c.weight),
        centre, c.scale, LEVER,
    )  # fmt: skip
    return with_less_head(A, b, c.head)


def depth_term(
    model: TrackingModel,
    match: DepthCorrespondences,
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
    config: BlendshapeFitConfig,
) -> tuple[System, float, float]:
    """Point-to-plane, eq. 1: n' (v1(x) - p) = 0 for every vertex that corresponds.

    Returns the normal equations, the mean distance (mm; NaN where nothing corresponds) and the area's share that does.
    """
    blocks = model.packed_basis
    A, b, error, covered = track_fit.plane_system(
        blocks.order, blocks.columns, blocks.values, model.shapes, T_camera_face.rotation,
        match.points, match.found, match.plane, match.weight, model.share * np.float32(POINTS),
        centre, config.robust_scale_mm, LEVER,
    )  # fmt: skip
    return (A, b), error if covered else np.nan, covered / POINTS


def _solve(A: np.ndarray, b: np.ndarray, x: np.ndarray, pose: bool) -> tuple[np.ndarray, float]:
    """The change (k + 6,) that keeps every coefficient in 0..1, and the breach of optimality."""
    k = len(x)
    free = np.full(6, np.inf if pose else 0.0)
    A[range(k, k + 6), range(k, k + 6)] += POSE_RIDGE * np.trace(A) / len(A)
    return box_solve(A, b, np.r_[-x, -free], np.r_[1 - x, free], np.zeros(k + 6))


def first_frame_fit(config: BlendshapeFitConfig) -> BlendshapeFitConfig:
    """The same fit without memory of the last frame, and farther to go: for the first and after a loss."""
    return replace(config, temporal_weight=0.0, rounds=config.rounds + 1)
