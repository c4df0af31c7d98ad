"""One frame of tracking (Li et al. 2013, sec. 4): a pure step from state to state, in the paper's order."""

from dataclasses import replace

import numpy as np

from ..depth import RGBDFrame
from ..landmarks.detector import Landmarks2D
from .detect import WrongScale
from .preprocess_frame import usable
from .stages import (
    adaptive_space,
    carry_landmarks,
    damped,
    find_head,
    initial_blendshapes,
    learn_appearance,
    learn_correctives,
    learn_skin_motion,
    learn_standing_errors,
    observed_frame,
    output_deformation,
    remove_standing_errors,
    rigid_motion,
    weights_anew,
)
from .tracker_context import TrackerContext, TrackResult, TrackState


def step(
    context: TrackerContext,
    frame: RGBDFrame,
    landmarks: Landmarks2D | None,
    state: TrackState,
    late: bool = False,
) -> tuple[TrackState, TrackResult]:
    """Track one frame. What is not finite in it is left out; a frame that gives no finite face counts as lost.

    Args:
        landmarks: of this frame; None where no face was found or nobody looked.
        late: the landmarks are those of the frame before: they are carried along with the head's rigid motion.

    Raises:
        BadInput: on finding the head, the depth turns out to have another unit.
    """
    T_camera_face = find_head(context, frame, usable(landmarks), state)
    if T_camera_face is None:
        return lost(context, state, frame)
    observation = observed_frame(context, frame, usable(landmarks), state, T_camera_face)
    rigid = rigid_motion(context, observation, state, T_camera_face)
    if not rigid.converged:
        return lost(context, state, frame)
    if late and not state.lost:
        observation = carry_landmarks(observation, state, rigid.T_camera_face, context.model)
    unbiased = remove_standing_errors(context, observation, state, rigid.T_camera_face)
    fit, filtered = initial_blendshapes(context, unbiased, rigid.T_camera_face, state, frame.time)
    v1 = context.model.blend(fit.weights)
    sample, v3 = adaptive_space(context, unbiased, v1, fit.T_camera_face, state)
    v4 = output_deformation(context, unbiased, v3, fit.T_camera_face)
    learning = learn_correctives(context, sample, v4, state)
    bias, baseline = learn_standing_errors(context, observation, v3, fit, state)
    reference = learn_appearance(context, observation, v1, fit, state)
    after = replace(
        state,
        T_camera_face=damped(context, state, fit.T_camera_face),
        vertices=v4,
        weights=filtered,
        correctives=learning.correctives,
        landmark_bias=bias,
        baseline=baseline,
        reference=reference,
        motion=learn_skin_motion(context, v1, state),
        lost=False,
        time=frame.time,
    )
    result = TrackResult(
        tracked=True,
        T_camera_face=after.T_camera_face,
        fitted=fit.weights,
        weights=weights_anew(context, v4, fit.weights),
        blend=v1,
        vertices=v4,
        error=rigid.error,
        to_anchors=learning.to_anchors,
        to_adaptive=learning.to_adaptive,
        learnt=learning.learnt,
        breach=fit.breach,
    )
    return (after, result) if finite(after) else lost(context, state, frame)


def step_or_lose(
    context: TrackerContext,
    frame: RGBDFrame,
    landmarks: Landmarks2D | None,
    state: TrackState,
    late: bool = False,
) -> tuple[TrackState, TrackResult]:
    """`step`; but a head that was tracked before and now seems of another size (behind a hand, say) counts as lost.

    Raises:
        BadInput: of another size from the first.
    """
    try:
        return step(context, frame, landmarks, state, late=late)
    except WrongScale:
        if state.weights is None:
            raise
        return step(context, frame, None, state, late=late)


def lost(context: TrackerContext, state: TrackState, frame: RGBDFrame) -> tuple[TrackState, TrackResult]:
    """Hold what was last known; the next frame looks for the head anew."""
    held = np.zeros(context.model.shapes) if state.weights is None else np.clip(state.weights.values, 0, 1)
    nan = float("nan")
    result = TrackResult(
        tracked=False,
        T_camera_face=state.T_camera_face,
        fitted=held,
        weights=held,
        blend=context.model.blend(held),
        vertices=state.vertices,
        error=nan,
        to_anchors=nan,
        to_adaptive=nan,
        learnt=False,
    )
    return replace(state, lost=True, time=frame.time), result


def finite(state: TrackState) -> bool:
    """Whether the next frame can go on from here."""
    pose, weights = state.T_camera_face, state.weights
    numbers = [pose.rotation, pose.translation, state.vertices, state.landmark_bias.moments, state.baseline.level]
    numbers.append(state.motion.squares)
    numbers += [] if weights is None else [weights.mean, weights.covariance]
    return all(np.isfinite(part).all() for part in numbers)
