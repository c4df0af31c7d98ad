"""The fit of the initial blendshapes (Li et al. 2013, sec. 4.2): one function a term, one box-constrained solve.

A term is rows J and a right-hand side r, both times the root of its weight: J @ z should be r, where z is the change of
the k coefficients, then a turn of the head (in 1/100 rad about the front's centre) and a shift (mm). Feature terms
return them; the depth term, of thousands of rows, returns their normal equations J'J and J'r at once.

Units. The paper's w = 5e-5 weighs squared c_F, which carries the focal length: with its Kinect (f = 525 pixels) that is
w f^2 = 13.8 on the plane z = 1, where c_F is in millimetres at the face: one feature counts like 14 depth points,
whatever the camera. The depth term counts as much as the paper's 3,480 points, shared out by area, whatever the mesh.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Float32, Int

from .._kernels import icp, track, track_fit
from ..landmarks.on_rig import FEATURES, LIDS, LIPS
from ..transforms import Transform
from .model import POINTS, TrackingModel
from .photometric import PhotometricConfig, Reference, photometric_match
from .preprocess_frame import FrameObservation
from .reproject_weights import box_solve
from .rigid import LEVER, DepthCorrespondences, RigidConfig, correspond, moved, pose_step

Rows = tuple[np.ndarray, np.ndarray]
"""J (rows, k + 6) and r (rows,), weighted."""
System = tuple[np.ndarray, np.ndarray]
"""J'J (k + 6, k + 6) and J'r (k + 6,)."""

POSE_RIDGE = 1e-6
"""Weight of the pose's change, of the mean diagonal: keeps the solve definite where nothing speaks of the pose."""


@dataclass(frozen=True)
class BlendshapeFitConfig:
    """The blendshape fit. Weights are squared, in the units of the module's first lines."""

    rounds: int = 3
    """Times that correspondences are found anew."""
    features: float = 0.5
    """Weight of a 2D feature; 0 = depth alone. The paper's is 13.8; MediaPipe's points err by 0.5 to 1 mm in ways that
    do not average out, so that here they are worth little."""
    alone: float = 13.8
    """The same where there is no depth."""
    gaps: float = 0.0
    """Weight of the opening between two lids or lips, which errors common to both do not touch; 0 = none. Off, since
    MediaPipe's openings err by half a millimetre and more."""
    robust_scale_mm: float = 30.0
    """Residuals much above this lose weight, mm. Large = plain least squares."""
    ridge: float = 20.0
    """Weight of each squared coefficient."""
    l1: float = 20.0
    """Weight of each coefficient's absolute value: prefers few shapes."""
    l1_per_mm: float = 40.0
    """The same for each millimetre (root mean square over the front) that a shape moves the face at weight 1."""
    reweight_eps: float = 0.15
    """Coefficient at which both of these weigh half: what is surely there is not held back. Large = plain."""
    temporal_weight: float = 20.0
    """Weight of the squared change since the last frame."""
    scores: float = 150.0
    """Weight of the squared distance to the landmarker's own scores of smiles."""
    eyes: float = 1000.0
    """The same for blinks and gaze to the side, of which depth sees little."""
    head_relative_landmarks: bool = True
    """Beside depth, let features speak of one another's places alone, not of the head's: their errors have much in
    common, and depth knows better where the head is. False = the paper's."""
    refine_pose_mm: float = 1.0
    """After each solve the head's pose is measured anew on the steadiest vertices, residuals above this (mm) losing
    weight; 0 = not."""
    photometric: PhotometricConfig = field(default_factory=PhotometricConfig)
    others: float = 100.0
    """Weight of the squared distance to the landmarker's scores of brows, squints, jaw and pulled lips."""
    pose: bool = True
    """Let the head move along with the coefficients (past the paper: sec. 4.1 alone leaves up to 3 mm)."""


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
) -> FitResult:
    """Alternate correspondences and box-constrained solves, from the last frame's weights and this frame's pose."""
    x, error, covered, breach = weights, np.nan, 0.0, 0.0
    normals = track.vertex_normals(model.blend(x), model.faces)
    match = None
    for done in range(config.rounds):
        centre = T_camera_face.apply(model.centre[None])[0]
        match = None
        A, b = normal_equations(_feature_rows(model, observation, x, T_camera_face, centre, config), model.shapes)
        if observation.depth is not None:
            match = correspond(model.blend(x), normals, T_camera_face, observation, rigid)
            (gram, product), error, covered = depth_term(model, match, T_camera_face, centre, config)
            A, b = A + gram, b + product
        look = appearance(model, observation, match, x, normals, T_camera_face, reference, done, config)
        if look is not None:
            gram, product = photometric_term(model, look, T_camera_face, centre, config)
            A, b = A + gram, b + product
        _add_priors(A, b, x, weights, observation.landmark_scores, model, config)
        change, left = _solve(A, b, x, config.pose)
        breach = max(breach, left)
        x = np.clip(x + change[: model.shapes], 0.0, 1.0)
        motion = change[model.shapes :].copy()
        motion[:3] /= LEVER
        T_camera_face = moved(T_camera_face, motion, centre)
        if match is not None and config.refine_pose_mm:
            T_camera_face = refine_pose(model, model.blend(x), match, T_camera_face, config)
    return FitResult(x, T_camera_face, error, covered, breach, None if match is None else match.weight)


def refine_pose(
    model: TrackingModel,
    vertices: Float32[np.ndarray, "f 3"],
    match: DepthCorrespondences,
    T_camera_face: Transform,
    config: BlendshapeFitConfig,
) -> Transform:
    """One ICP step of the fitted face, measured on the vertices that expressions move least."""
    points = track.place(vertices, T_camera_face.rotation, T_camera_face.translation)
    centre = T_camera_face.apply(model.centre[None])[0]
    weight = match.weight * model.pose_weights
    A, b, _, _ = icp.rigid_system(points, match.found, match.plane, weight, centre, config.refine_pose_mm)
    return moved(T_camera_face, pose_step(A, b), centre)


def appearance(
    model: TrackingModel, observation: FrameObservation, match: DepthCorrespondences | None, x, normals, T_camera_face,
    reference: Reference | None, done: int, config: BlendshapeFitConfig,
) -> DepthCorrespondences | None:  # fmt: skip
    """Planes that the vertices should lie on to show what they used to; None where nothing is known of that."""
    if observation.contrast is None or reference is None or not reference.frames or not config.photometric.weight:
        return None
    c = config.photometric
    level = sorted(set(c.smooth)).index(c.smooth[min(done, len(c.smooth) - 1)])
    points = track.place(model.blend(x), T_camera_face.rotation, T_camera_face.translation)
    turned = track.place(normals, T_camera_face.rotation, np.zeros(3))
    valid = reference.weight(c.frames)
    if match is not None:
        valid = valid * (match.weight > 0)
    found, plane, weight, _ = photometric_match(
        points, turned, observation.contrast[level], observation.intrinsics, reference.contrast[level], valid, c
    )
    return DepthCorrespondences(points, found, plane, weight)


def photometric_term(
    model: TrackingModel, look: DepthCorrespondences, T_camera_face: Transform, centre, config: BlendshapeFitConfig
) -> System:
    """Contrast as remembered, for every vertex that is seen: the normal equations."""
    packed, c = model.packed_basis, config.photometric
    A, b, _, _ = track_fit.plane_system(
        packed.order, packed.columns, packed.values, model.shapes, T_camera_face.rotation,
        look.points, look.found, look.plane, look.weight, model.share * np.float32(POINTS * c.weight),
        centre, c.scale, LEVER,
    )  # fmt: skip
    return A, b


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


def _feature_rows(
    model, observation: FrameObservation, x, T_camera_face, centre, config: BlendshapeFitConfig
) -> list[Rows]:
    """The terms of the features."""
    if observation.rays is None or not config.features:
        return []
    ids = _landmarks_used(model, observation)
    if observation.depth is None:
        config = replace(config, features=config.alone)
    seen = feature_term(model, ids, observation.rays[ids], x, T_camera_face, centre, config)
    terms = [without_head(*seen) if config.head_relative_landmarks and observation.depth is not None else seen]
    if config.gaps:
        terms.append(gap_term(model, observation.rays, x, T_camera_face, centre, config))
    return terms


def feature_term(
    model: TrackingModel,
    ids: Int[np.ndarray, " j"],
    rays: Float[np.ndarray, "j 2"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
    config: BlendshapeFitConfig,
) -> Rows:
    """2D features, eq. 2: [1 0 -u_x; 0 1 -u_y] v = 0 in camera space; in millimetres at the face.

    More than 40 landmarks share the weight of 40; rays that are NaN give rows of zeros.
    """
    J, points = landmark_rows(model, ids, weights, T_camera_face, centre)
    known = np.asarray(np.isfinite(rays).all(axis=1))
    rays = np.where(np.isfinite(rays), rays, 0.0)
    right = rays * points[:, 2:] - points[:, :2]
    each = np.sqrt(config.features * len(FEATURES) / max(len(ids), 1))
    root = known * each / (1 + (right**2).sum(1) / config.robust_scale_mm**2)
    rows = (J[:, :2] - rays[:, :, None] * J[:, 2:]) * root[:, None, None]
    return rows.reshape(-1, J.shape[2]), (right * root[:, None]).ravel()


def without_head(rows: Float[np.ndarray, "rows c"], right: Float[np.ndarray, " rows"]) -> Rows:
    """Feature rows from which a shift common to all, and any say in the head's pose, are taken out."""
    pairs, offsets = rows.reshape(-1, 2, rows.shape[1]).copy(), right.reshape(-1, 2).copy()
    known = np.abs(pairs).sum((1, 2)) > 0
    pairs[:, :, -6:] = 0.0
    pairs[known] -= pairs[known].mean(0)
    offsets[known] -= offsets[known].mean(0)
    return pairs.reshape(rows.shape), offsets.ravel()


def gap_term(
    model: TrackingModel,
    rays: Float[np.ndarray, "478 2"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
    config: BlendshapeFitConfig,
) -> Rows:
    """Openings between lids and between lips (mm): their 2D difference, on which common errors of both sides cancel."""
    pairs = np.array([*LIDS, *LIPS])
    J, points = landmark_rows(model, pairs.ravel(), weights, T_camera_face, centre)
    z = points[:, 2].mean()
    seen = (rays[pairs[:, 0]] - rays[pairs[:, 1]]) * z
    known = np.isfinite(seen).all(1)[:, None]
    J, points = J.reshape(len(pairs), 2, 3, -1), points.reshape(len(pairs), 2, 3)
    right = np.where(known, seen - (points[:, 0, :2] - points[:, 1, :2]), 0.0)
    rows = (J[:, 0, :2] - J[:, 1, :2]) * known[:, None]
    root = np.sqrt(config.gaps)
    return root * rows.reshape(-1, rows.shape[2]), root * right.ravel()


def landmark_rows(
    model: TrackingModel,
    ids: Int[np.ndarray, " j"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
) -> tuple[Float[np.ndarray, "j 3 c"], Float[np.ndarray, "j 3"]]:
    """Landmarks in camera space (mm) and their derivatives by the k coefficients, turn and shift (c = k + 6)."""
    return track_fit.landmark_rows(
        model.landmark_neutral[ids], model.landmark_basis[ids], weights, T_camera_face.rotation,
        T_camera_face.translation, centre, LEVER,
    )  # fmt: skip


def normal_equations(terms: list[Rows], shapes: int) -> tuple[Float[np.ndarray, "c c"], Float[np.ndarray, " c"]]:
    """Sum of J'J and of J'r over the terms, float64 (c = shapes + 6)."""
    A, b = np.zeros((shapes + 6, shapes + 6)), np.zeros(shapes + 6)
    for rows, right in terms:
        gram, product = track.normal_equations(rows.astype(np.float32), right.astype(np.float32))
        A += gram
        b += product
    return A, b


def _landmarks_used(model: TrackingModel, observation: FrameObservation) -> np.ndarray:
    """The 40 features beside depth; without depth all the landmarks that are known."""
    if observation.depth is not None:
        return np.array(FEATURES)
    return np.flatnonzero(model.landmarks.known)


def _add_priors(A, b, x, before, scores, model: TrackingModel, config: BlendshapeFitConfig) -> None:
    """Ridge, sparsity, stillness and the landmarker's scores, added in place to the coefficients' equations."""
    k = len(x)
    diagonal = np.full(k, config.ridge + config.temporal_weight)
    price = (config.l1 + config.l1_per_mm * model.size) / (1 + x / config.reweight_eps)
    b[:k] += config.temporal_weight * before - diagonal * x - price / 2
    if scores is not None:
        lesser = np.where(model.smiles, config.scores, config.others * model.scored)
        trust = np.where(model.eyes, config.eyes, lesser) * np.isfinite(scores)
        b[:k] += trust * (np.nan_to_num(scores) - x)
        diagonal += trust
    A[np.arange(k), np.arange(k)] += diagonal


def _solve(A: np.ndarray, b: np.ndarray, x: np.ndarray, pose: bool) -> tuple[np.ndarray, float]:
    """The change (k + 6,) that keeps every coefficient in 0..1, and the breach of optimality."""
    k = len(x)
    free = np.full(6, np.inf if pose else 0.0)
    A[range(k, k + 6), range(k, k + 6)] += POSE_RIDGE * np.trace(A) / len(A)
    return box_solve(A, b, np.r_[-x, -free], np.r_[1 - x, free], np.zeros(k + 6))


def first_frame_fit(config: BlendshapeFitConfig) -> BlendshapeFitConfig:
    """The same fit without memory of the last frame: for the first frame and after the head was lost."""
    return replace(config, temporal_weight=0.0)
