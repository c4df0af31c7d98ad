"""The stages of a tracked frame (Li et al. 2013, sec. 4 and 5), each a function of context, frame and state."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32

from .._kernels import track
from ..depth import RGBDFrame
from ..landmarks.detector import Landmarks2D
from ..solve import kalman as filters
from ..transforms import Transform
from .adaptive import Subspace, depth_offsets, feature_offsets, weighted_subspace
from .detect import detect
from .fit import FitResult, first_frame_fit, fit_blendshapes
from .hidden.find_in_depth import find_in_depth
from .landmark_bias import learn_baseline, learn_bias, subtract_baseline, subtract_bias
from .model import TrackingModel
from .preprocess_frame import FrameObservation, preprocess_frame, scores_of
from .rigid import RigidResult, align, correspond, damp_pose
from .terms.photometric import learn_reference
from .terms.skin_motion import SkinMotion, learn_motion
from .tracker_context import TrackerContext, TrackState, timed

SHORTEST = 1e-3
"""Seconds between two frames, at least: for frames whose clock stands still or runs back."""
OUTLINE_STEP, POSE_STEP = 8, 32
"""Every so manieth vertex of the front outlines the window, and measures how far the head moved."""


def find_head(
    context: TrackerContext, frame: RGBDFrame, landmarks: Landmarks2D | None, state: TrackState
) -> Transform | None:
    """Where the head was; not known, where depth alone (if wanted) or the landmarks see it; None where neither does."""
    if not state.lost:
        return state.T_camera_face
    if context.config.find_in_depth:
        found = find_in_depth(context.model, frame, context.camera, context.config.rigid)
        if found is not None:
            return found
    return None if landmarks is None else detect(context.model, frame, landmarks, context.camera)


@timed("crop and smooth")
def observed_frame(
    context: TrackerContext,
    frame: RGBDFrame,
    landmarks: Landmarks2D | None,
    state: TrackState,
    T_camera_face: Transform,
) -> FrameObservation:
    """Sec. 4.1: a window round the front as it was, depth smoothed in it; the landmarks as rays, their scores."""
    points = T_camera_face.apply(state.vertices[::OUTLINE_STEP].astype(np.float64))
    outline = context.camera.project(points)
    config = context.config
    seen = preprocess_frame(frame, context.camera, outline, landmarks, config.preprocess, config.fit.photometric)
    if seen.rays is not None:
        seen = seen.moved(np.where(context.model.landmarks.known[:, None], seen.rays, np.nan))
    return replace(seen, landmark_scores=scores_of(landmarks, context.model.rig.names))


@timed("rigid motion")
def rigid_motion(
    context: TrackerContext, observation: FrameObservation, state: TrackState, T_camera_face: Transform
) -> RigidResult:
    """Sec. 4.1: the last frame's face, as it is, onto this frame's depth; without depth it stays where it is."""
    if observation.depth is None:
        return RigidResult(T_camera_face, float("nan"), 0.0, observation.rays is not None, 0)
    model = context.model
    return align(state.vertices, model.faces, model.share, T_camera_face, observation, context.config.rigid)


def carry_landmarks(
    observation: FrameObservation, state: TrackState, T_camera_face: Transform, model: TrackingModel
) -> FrameObservation:
    """Landmarks of the last frame, moved with the head since: each on the depth that the model has there."""
    if observation.rays is None:
        return observation
    T_now_then = T_camera_face @ state.T_camera_face.inverse()
    depth = state.T_camera_face.apply(model.landmark_neutral)[:, 2:]
    rays = np.concatenate([observation.rays, np.ones_like(depth)], 1)
    points = T_now_then.apply(rays * depth)
    return observation.moved(points[:, :2] / points[:, 2:])


def remove_standing_errors(
    context: TrackerContext, observation: FrameObservation, state: TrackState, T_camera_face: Transform
) -> FrameObservation:
    """Take out what the landmarker always gets wrong about this face."""
    config = context.config.landmark_bias
    corrected = subtract_bias(observation, state.landmark_bias, context.model, T_camera_face, config)
    scores = None
    if state.baseline.count and observation.landmark_scores is not None:
        scores = subtract_baseline(observation.landmark_scores, state.baseline)
    return replace(corrected, landmark_scores=scores)


@timed("initial blendshapes")
def initial_blendshapes(
    context: TrackerContext,
    observation: FrameObservation,
    T_camera_face: Transform,
    state: TrackState,
    time: float,
) -> tuple[FitResult, filters.KalmanState]:
    """Sec. 4.2: fit from the last frame's coefficients, then filter them; the fit's weights are the filtered ones."""
    config = context.config
    last = None if state.lost else state.weights
    before = np.zeros(context.model.shapes) if last is None else np.clip(last.values, 0, 1)
    fitting = first_frame_fit(config.fit) if last is None else config.fit
    still = state.motion.pose_weights(context.model.share)
    fit = fit_blendshapes(
        context.model, observation, before, T_camera_face, fitting, config.rigid, state.reference, still
    )
    if last is None or not config.smooth:
        return fit, filters.start(fit.weights, config.kalman)
    filtered = filters.step(last, fit.weights, max(time - state.time, SHORTEST), config.kalman)
    return replace(fit, weights=np.clip(filtered.values, 0, 1)), filtered


@timed("adaptive space")
def adaptive_space(
    context: TrackerContext, observation: FrameObservation, v1, T_camera_face: Transform, state: TrackState
) -> tuple[Float32[np.ndarray, "f 3"] | None, Float32[np.ndarray, "f 3"]]:
    """Sec. 4.3: v2 = v1 + dv by depth and features, v3 = its projection onto M = [M_A, M_K].

    Returns what of v2 lies outside the anchor space, the sample of sec. 5, and v3.
    """
    config, model = context.config, context.model
    if not config.adaptive or observation.depth is None:
        return None, v1
    normals = track.vertex_normals(v1, model.faces)
    match = correspond(v1, normals, T_camera_face, observation, config.rigid)
    offsets = depth_offsets(match, T_camera_face)
    features = feature_offsets(model, v1, observation, T_camera_face, config.deformation.reach)
    v2 = v1 + context.deformation.with_depth(offsets, features)
    displacement = v2 - model.neutral
    anchored = context.anchors.project(displacement)
    sample, v3 = displacement - anchored, model.neutral + anchored
    return sample, v3 if state.correctives is None else v3 + state.correctives.project(sample)


@timed("output deformation")
def output_deformation(
    context: TrackerContext, observation: FrameObservation, v3, T_camera_face: Transform
) -> Float32[np.ndarray, "f 3"]:
    """Sec. 4.4: v4 = v3 + dv by the features alone."""
    if not context.config.output or observation.rays is None:
        return v3
    reach = context.config.deformation.reach
    features = feature_offsets(context.model, v3, observation, T_camera_face, reach, use_depth=False)
    return v3 + context.deformation.with_features(features)


@dataclass(frozen=True)
class Learning:
    """What sec. 5 made of a frame."""

    to_anchors: float
    """mm, root mean square over the front's area."""
    to_adaptive: float
    learnt: bool
    correctives: Subspace | None


@timed("incremental PCA")
def learn_correctives(context: TrackerContext, sample, v4, state: TrackState) -> Learning:
    """Sec. 5: what lies outside the anchor space is learnt from, if it is far enough and not too far.

    A sample enters in one frame and changes the correctives in the next: neighbours show nearly the same, and no frame
    has to do both.
    """
    model, config, correctives = context.model, context.config, state.correctives
    to_anchors, to_adaptive = distances(model, v4 - model.neutral, context.anchors, correctives)
    pending = state.learner.pending
    learnt = state.learner.update()
    if config.correctives and not pending and sample is not None and config.near < rms(model, sample) < config.far:
        state.learner.enter((sample * np.sqrt(model.share)[:, None]).ravel())
    if learnt:
        correctives = weighted_subspace(model, state.learner.basis.T)
    return Learning(to_anchors, to_adaptive, learnt, correctives)


def distances(
    model: TrackingModel, displacement: Float32[np.ndarray, "f 3"], anchors: Subspace, correctives: Subspace | None
) -> tuple[float, float]:
    """How far a displacement lies from the anchors' space and from the adaptive one, mm, root mean square.

    By Pythagoras: correctives are learnt from what lies outside the anchors' space, so they are at right angles to it.
    """
    whole = rms(model, displacement) ** 2
    outside = whole - float((anchors.coefficients(displacement) ** 2).sum())
    beyond = outside if correctives is None else outside - float((correctives.coefficients(displacement) ** 2).sum())
    return max(outside, 0.0) ** 0.5, max(beyond, 0.0) ** 0.5


def rms(model: TrackingModel, displacement: Float32[np.ndarray, "f 3"]) -> float:
    """Root mean square over the front's area, mm."""
    return float(np.sqrt(track.mean_square(model.share, displacement)))


@timed("standing errors")
def learn_standing_errors(
    context: TrackerContext, observation: FrameObservation, v3, fit: FitResult, state: TrackState
):
    """Compare what the landmarker saw and scored with the tracked face."""
    config = context.config.landmark_bias
    bias = learn_bias(state.landmark_bias, context.model, v3, observation, fit.T_camera_face, config)
    scores = observation.landmark_scores
    if scores is None:
        return bias, state.baseline
    return bias, learn_baseline(state.baseline, scores, fit.weights, config)


@timed("appearance")
def learn_appearance(context: TrackerContext, observation: FrameObservation, v1, fit: FitResult, state: TrackState):
    """Remember what the skin showed, in the first frames."""
    return learn_reference(
        state.reference,
        observation.contrast,
        observation.intrinsics,
        v1,
        context.model.faces,
        fit.seen,
        fit.T_camera_face,
        context.config.fit.photometric,
    )


@timed("skin motion")
def learn_skin_motion(context: TrackerContext, v1, state: TrackState) -> SkinMotion:
    """Remember how far the skin has moved, for the pose of the frames to come."""
    return learn_motion(state.motion, v1 - context.model.neutral)


@timed("weights anew")
def weights_anew(context: TrackerContext, v4, fitted: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
    """Sec. 6: the coefficients solved again on the final mesh, if that is wanted."""
    if not context.config.anew:
        return fitted
    return context.reprojection.weights(v4, fitted)


def damped(context: TrackerContext, state: TrackState, T_camera_face: Transform) -> Transform:
    """The pose, small motion held back; a head just found is where it was found."""
    if state.lost:
        return T_camera_face
    model = context.model
    points = model.neutral[::POSE_STEP].astype(np.float64)
    return damp_pose(points, model.centre, state.T_camera_face, T_camera_face, context.config.damp_pose_mm)
