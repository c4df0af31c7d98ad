"""One frame of tracking (Li et al. 2013, sec. 4): a pure step from state to state, and a few lines round it."""

from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Float32

from .._kernels import track
from ..camera import Camera
from ..depth import RGBDFrame
from ..landmarks.detector import Landmarks2D
from ..solve import kalman as filters
from ..solve.incremental_pca import IncrementalPca, IncrementalPcaConfig
from ..transforms import Transform, rotation_from_vector, vector_from_rotation
from .adaptive import (
    DeformConfig,
    LaplacianDeformation,
    Subspace,
    anchor_space,
    depth_offsets,
    feature_offsets,
    weighted_subspace,
)
from .detect import detect
from .fit import FitConfig, at_rest, fit_blendshapes
from .landmark_bias import Bias, BiasConfig, Rest, above, corrected, learn, learn_rest, no_bias
from .model import TrackingModel
from .preprocess_frame import ObserveConfig, Sighting, observe
from .reproject_weights import Resolver
from .rigid import RigidConfig, align, correspond


@dataclass(frozen=True)
class TrackConfig:
    """The tracker. Every stage can be left out, to see what it is good for."""

    observe: ObserveConfig = field(default_factory=ObserveConfig)
    rigid: RigidConfig = field(default_factory=RigidConfig)
    fit: FitConfig = field(default_factory=FitConfig)
    kalman: filters.KalmanConfig = field(default_factory=filters.KalmanConfig)
    deform: DeformConfig = field(default_factory=DeformConfig)
    pca: IncrementalPcaConfig = field(default_factory=lambda: IncrementalPcaConfig(warm_up=30))
    """The paper waits for a full buffer of 200 samples before the first update; 30 learn sooner."""
    bias: BiasConfig = field(default_factory=BiasConfig)
    smooth: bool = True
    """The Kalman filter on the coefficients."""
    steady: float = 0.3
    """Head motion of this size from frame to frame, mm, counts half as noise and is half held back; 0 = none is."""
    adaptive: bool = True
    """The fit in the adaptive space (sec. 4.3); without it v3 = v1."""
    correctives: bool = True
    """Learning of corrective shapes (sec. 5); without it the adaptive space is the anchors'."""
    output: bool = True
    """The output deformation by 2D features (sec. 4.4); without it v4 = v3."""
    near: float = 0.1
    """A sample nearer to the anchor space than this teaches nothing; mm, root mean square over the front's area."""
    far: float = 1.7
    """A sample farther than this is an outlier. The paper's 1 < |s|^2 < 100 is a sum over its 3,480 vertices; taken in
    centimetres it is these two as root mean squares, which mean the same for any mesh."""


@runtime_checkable
class Watch(Protocol):
    """Whoever wants to know how long the stages take."""

    def lap(self, stage: str) -> None:
        """`stage` has just ended."""
        ...


class NoWatch:
    """Nobody does."""

    def lap(self, stage: str) -> None:
        """Ignore it."""


@dataclass(frozen=True)
class Tools:
    """What is worked out once for a model, a camera and a config."""

    model: TrackingModel
    camera: Camera
    deformation: LaplacianDeformation
    anchors: Subspace
    resolver: Resolver


def prepare(model: TrackingModel, camera: Camera, config: TrackConfig = TrackConfig()) -> Tools:
    """Factorise the Laplacian system, find the anchors: half a second, once."""
    return Tools(
        model, camera, LaplacianDeformation(model, config.deform), anchor_space(model), Resolver(model)
    )


@dataclass(frozen=True)
class TrackState:
    """What a frame leaves for the next. Given to `step` it is used up: `learner` is changed in place."""

    T_camera_face: Transform
    vertices: Float32[np.ndarray, "f 3"]
    """v4 of the last frame, face space, mm."""
    weights: filters.KalmanState | None
    """Filter of the blendshape coefficients; None until the first frame."""
    learner: IncrementalPca
    """The correctives, in coordinates times the root of the share."""
    correctives: Subspace | None
    bias: Bias
    """Standing errors of the features."""
    rest: Rest
    """Standing errors of the landmarker's scores."""
    lost: bool
    time: float
    """Seconds, of the last frame."""


@dataclass(frozen=True)
class TrackResult:
    """One frame's outcome."""

    tracked: bool
    """False: the head is lost, and what follows is the last frame's."""
    T_camera_face: Transform
    fitted: Float[np.ndarray, " k"]
    """x of the initial blendshape fit, filtered."""
    weights: Float[np.ndarray, " k"]
    """x solved anew on the final mesh (sec. 6)."""
    blend: Float32[np.ndarray, "f 3"]
    """v1 on the front, face space, mm."""
    vertices: Float32[np.ndarray, "f 3"]
    """v4."""
    error: float
    """Mean point-to-plane distance after the rigid step, mm."""
    to_anchors: float
    """Distance of v4 from the anchor space, mm rms over the front (the paper's fig. 11, green)."""
    to_adaptive: float
    """Distance of v4 from the adaptive space before this frame was learnt from, mm rms (fig. 11, blue)."""
    learnt: bool
    """Whether the frame changed the correctives."""


def begin(tools: Tools, config: TrackConfig = TrackConfig()) -> TrackState:
    """The state before the first frame: nothing is known yet."""
    model = tools.model
    return TrackState(
        T_camera_face=Transform.identity(),
        vertices=model.neutral,
        weights=None,
        learner=IncrementalPca(model.neutral.size, config.pca),
        correctives=None,
        bias=no_bias(config.bias),
        rest=Rest(np.zeros(model.shapes), 0.0),
        lost=True,
        time=-np.inf,
    )


def step(
    tools: Tools,
    frame: RGBDFrame,
    landmarks: Landmarks2D | None,
    state: TrackState,
    config: TrackConfig = TrackConfig(),
    watch: Watch = NoWatch(),
    late: bool = False,
) -> tuple[TrackState, TrackResult]:
    """Track one frame.

    Args:
        landmarks: of this frame; None where no face was found or nobody looked.
        late: the landmarks are those of the frame before: they are carried along with the head's rigid motion.

    Raises:
        BadInput: on finding the head, the depth turns out to have another unit.
    """
    model = tools.model
    if state.lost:
        if landmarks is None:
            return _lost(tools, state, frame)
        state = replace(state, T_camera_face=detect(model, frame, landmarks, tools.camera))
    sighting = observe(frame, tools.camera, _outline(tools, state), landmarks, config.observe)
    watch.lap("crop and smooth")
    T_camera_face, error = state.T_camera_face, np.nan
    if sighting.depth is not None:
        rigid = align(state.vertices, model.faces, model.share, T_camera_face, sighting, config.rigid)
        T_camera_face, error = rigid.T_camera_face, rigid.error
        watch.lap("rigid motion")
        if not rigid.converged:
            return _lost(tools, state, frame)
    elif landmarks is None:
        return _lost(tools, state, frame)
    if late and not state.lost:
        sighting = carried(sighting, state, T_camera_face, model)
    scores = _scores(model, landmarks)
    if state.rest.count:
        sighting = replace(sighting, said=above(scores, state.rest))
    raw, sighting = sighting, corrected(sighting, state.bias, model, T_camera_face, config.bias)
    x, T_camera_face, filtered = _blendshapes(tools, frame, sighting, T_camera_face, state, config)
    watch.lap("initial blendshapes")
    v1 = model.blend(x)
    sample, v3 = _adapt(tools, sighting, v1, T_camera_face, state, config)
    watch.lap("adaptive space")
    v4 = _output(tools, sighting, v3, T_camera_face, config)
    watch.lap("output deformation")
    distances, learnt, correctives = _learn(tools, sample, v4, state, config)
    watch.lap("incremental PCA")
    bias = learn(state.bias, model, v3, raw, T_camera_face, config.bias)
    rest = learn_rest(state.rest, scores, x, config.bias)
    watch.lap("standing errors")
    weights = tools.resolver.weights(v4, x)
    watch.lap("weights anew")
    if not state.lost:
        T_camera_face = steadied(model, state.T_camera_face, T_camera_face, config.steady)
    after = TrackState(T_camera_face, v4, filtered, state.learner, correctives, bias, rest, False, frame.time)
    return after, TrackResult(True, T_camera_face, x, weights, v1, v4, error, *distances, learnt)


def _outline(tools: Tools, state: TrackState) -> Float[np.ndarray, "n 2"]:
    """Pixels round which the window is laid: every eighth vertex of the front as it was."""
    points = state.T_camera_face.apply(state.vertices[::8].astype(np.float64))
    return tools.camera.project(points)


def _scores(model: TrackingModel, landmarks: Landmarks2D | None) -> Float[np.ndarray, " k"]:
    """What the landmarker says of each shape; NaN where nothing."""
    scores = {} if landmarks is None else landmarks.scores
    return np.array([scores.get(name, np.nan) for name in model.rig.names])


def _blendshapes(tools, frame, sighting: Sighting, T_camera_face, state: TrackState, config: TrackConfig):
    """Sec. 4.2: fit from the last frame's coefficients, then filter them."""
    last = None if state.lost else state.weights
    before = np.zeros(tools.model.shapes) if last is None else np.clip(last.values, 0, 1)
    fitting = at_rest(config.fit) if last is None else config.fit
    fit = fit_blendshapes(tools.model, sighting, before, T_camera_face, fitting, config.rigid)
    if last is None or not config.smooth:
        return fit.weights, fit.T_camera_face, filters.start(fit.weights, config.kalman)
    dt = max(frame.time - state.time, 1e-3)
    filtered = filters.step(last, fit.weights, dt, config.kalman)
    return np.clip(filtered.values, 0, 1), fit.T_camera_face, filtered


def _adapt(tools: Tools, sighting: Sighting, v1, T_camera_face, state: TrackState, config: TrackConfig):
    """Sec. 4.3: v2 = v1 + dv by depth and features, v3 = its projection onto M = [M_A, M_K].

    Returns what of v2 lies outside the anchor space, the sample of sec. 5, and v3.
    """
    if not config.adaptive or sighting.depth is None:
        return None, v1
    model = tools.model
    normals = track.vertex_normals(v1, model.faces)
    match = correspond(v1, normals, T_camera_face, sighting, config.rigid)
    offsets = depth_offsets(match, T_camera_face)
    features = feature_offsets(model, v1, sighting, T_camera_face, config.deform.reach)
    v2 = v1 + tools.deformation.with_depth(offsets, features)
    displacement = v2 - model.neutral
    anchored = tools.anchors.project(displacement)
    sample, v3 = displacement - anchored, model.neutral + anchored
    return sample, v3 if state.correctives is None else v3 + state.correctives.project(sample)


def _output(tools: Tools, sighting: Sighting, v3, T_camera_face, config: TrackConfig):
    """Sec. 4.4: v4 = v3 + dv by the features alone."""
    if not config.output or sighting.sight is None:
        return v3
    c = config.deform
    features = feature_offsets(tools.model, v3, sighting, T_camera_face, c.reach, use_depth=False)
    return v3 + tools.deformation.with_features(features)


def _learn(tools: Tools, sample, v4, state: TrackState, config: TrackConfig):
    """Sec. 5: what lies outside the anchor space is learnt from, if it is far enough and not too far."""
    model = tools.model
    residual = _outside(tools.anchors, v4 - model.neutral)
    to_anchors = _rms(model, residual)
    to_adaptive = _rms(model, residual if state.correctives is None else _outside(state.correctives, residual))
    learnt, correctives = False, state.correctives
    if config.correctives and sample is not None:
        if config.near < _rms(model, sample) < config.far:
            learnt = state.learner.add((sample * np.sqrt(model.share)[:, None]).ravel())
        if learnt:
            correctives = weighted_subspace(model, state.learner.basis.T)
    return (to_anchors, to_adaptive), learnt, correctives


def _outside(space: Subspace, displacement):
    return displacement - space.project(displacement)


def _rms(model: TrackingModel, displacement) -> float:
    return float(np.sqrt(track.mean_square(model.share, displacement)))


def carried(sighting: Sighting, state: TrackState, T_camera_face: Transform, model: TrackingModel) -> Sighting:
    """Landmarks of the last frame, moved with the head since: each on the depth that the model has there."""
    if sighting.sight is None:
        return sighting
    T_now_then = T_camera_face @ state.T_camera_face.inverse()
    depth = state.T_camera_face.apply(model.landmark_neutral)[:, 2:]
    points = T_now_then.apply(np.concatenate([sighting.sight, np.ones_like(depth)], 1) * depth)
    return sighting.moved(points[:, :2] / points[:, 2:])


def steadied(model: TrackingModel, before: Transform, now: Transform, size: float) -> Transform:
    """`now`, drawn back towards `before` by size^2 / (size^2 + d^2), d the motion of the front between them, mm rms."""
    points = model.neutral[::32].astype(np.float64)
    squared = float(((now.apply(points) - before.apply(points)) ** 2).sum(1).mean())
    part = squared / (squared + size**2) if squared else 1.0
    turn = vector_from_rotation(now.rotation @ before.rotation.T) * part
    rotation = rotation_from_vector(turn) @ before.rotation
    here = before.apply(model.centre[None])[0]
    there = now.apply(model.centre[None])[0]
    return Transform(rotation, here + part * (there - here) - rotation @ model.centre)


def _lost(tools: Tools, state: TrackState, frame: RGBDFrame) -> tuple[TrackState, TrackResult]:
    """Hold what was last known; the next frame looks for the head anew."""
    k = tools.model.shapes
    held = np.zeros(k) if state.weights is None else np.clip(state.weights.values, 0, 1)
    after = replace(state, lost=True, time=frame.time)
    blend = tools.model.blend(held)
    nan = float("nan")
    return after, TrackResult(
        False, state.T_camera_face, held, held, blend, state.vertices, nan, nan, nan, False
    )
