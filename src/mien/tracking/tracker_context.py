"""What the tracker is set up with, what a frame leaves for the next, and what it gives."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import wraps
from typing import ParamSpec, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float, Float32

from .._kernels import track
from ..camera import Camera
from ..solve.incremental_pca import IncrementalPca, IncrementalPcaConfig
from ..solve.kalman import KalmanConfig, KalmanState
from ..transforms import Transform
from .adaptive import DeformConfig, LaplacianDeformation, Subspace, anchor_space
from .landmark_bias import Bias, BiasConfig, ScoreBaseline, no_baseline, no_bias
from .model import TrackingModel
from .preprocess_frame import PreprocessFrameConfig
from .reproject_weights import WeightReprojection
from .rigid import RigidConfig
from .terms.fit_config import BlendshapeFitConfig
from .terms.photometric import Reference, no_reference
from .terms.skin_motion import SkinMotion, no_motion

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class TrackConfig:
    """The tracker. Every stage can be left out, to see what it is good for."""

    preprocess: PreprocessFrameConfig = field(default_factory=PreprocessFrameConfig)
    rigid: RigidConfig = field(default_factory=RigidConfig)
    fit: BlendshapeFitConfig = field(default_factory=BlendshapeFitConfig)
    kalman: KalmanConfig = field(default_factory=KalmanConfig)
    deformation: DeformConfig = field(default_factory=DeformConfig)
    pca: IncrementalPcaConfig = field(default_factory=lambda: IncrementalPcaConfig(warm_up=15))
    """The paper waits for a full buffer of 200 samples before the first update; 15 learn sooner. Every other frame is a
    sample."""
    landmark_bias: BiasConfig = field(default_factory=BiasConfig)
    find_in_depth: bool = False
    """Find the face by its depth before its landmarks (0.1 s): for one that is partly hidden."""
    smooth: bool = True
    """The Kalman filter on the coefficients."""
    damp_pose_mm: float = 0.3
    """Head motion of this size from frame to frame, mm, counts half as noise and is half held back; 0 = none is."""
    adaptive: bool = True
    """The fit in the adaptive space (sec. 4.3); without it v3 = v1."""
    correctives: bool = True
    """Learning of corrective shapes (sec. 5); without it the adaptive space is the anchors'."""
    output: bool = True
    """The output deformation by 2D features (sec. 4.4); without it v4 = v3."""
    anew: bool = False
    """Solve the coefficients again on the final mesh (sec. 6). Without it they are the blendshape fit's, which lie
    nearer to the true ones: what the final mesh adds is put down to shapes that have no part in it."""
    near: float = 0.1
    """A sample nearer to the anchor space than this teaches nothing; mm, root mean square over the front's area."""
    far: float = 1.7
    """A sample farther than this is an outlier. The paper's 1 < |s|^2 < 100 is a sum over its 3,480 vertices; taken in
    centimetres it is these two as root mean squares, which mean the same for any mesh."""


@runtime_checkable
class StageTimer(Protocol):
    """Whoever wants to know how long the stages take."""

    def stage(self, name: str) -> AbstractContextManager:
        """What is done inside belongs to the stage called `name`."""
        ...


class NoTimer:
    """Nobody does."""

    def stage(self, name: str) -> AbstractContextManager:
        """Do nothing."""
        return nullcontext()


def timed(name: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let the context's timer, which is the first argument's, know what the function took: decorates a stage."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def watched(*args: P.args, **kwargs: P.kwargs) -> R:
            context: TrackerContext = args[0]  # pyright: ignore[reportAssignmentType]
            with context.timer.stage(name):
                return function(*args, **kwargs)

        return watched

    return decorate


@dataclass(frozen=True)
class TrackerContext:
    """What is worked out once for a model, a camera and a config."""

    model: TrackingModel
    camera: Camera
    config: TrackConfig
    deformation: LaplacianDeformation
    anchors: Subspace
    reprojection: WeightReprojection
    timer: StageTimer


def tracker_context(
    model: TrackingModel, camera: Camera, config: TrackConfig = TrackConfig(), timer: StageTimer = NoTimer()
) -> TrackerContext:
    """Factorise the Laplacian system, find the anchors: half a second, once."""
    return TrackerContext(
        model=model,
        camera=camera,
        config=config,
        deformation=LaplacianDeformation(model, config.deformation),
        anchors=anchor_space(model),
        reprojection=WeightReprojection(model),
        timer=timer,
    )


@dataclass(frozen=True)
class TrackState:
    """What a frame leaves for the next. Given to `step` it is used up: `learner` is changed in place."""

    T_camera_face: Transform
    vertices: Float32[np.ndarray, "f 3"]
    """v4 of the last frame, face space, mm."""
    weights: KalmanState | None
    """Filter of the blendshape coefficients; None until the first frame."""
    learner: IncrementalPca
    """The correctives, in coordinates times the root of the share."""
    correctives: Subspace | None
    landmark_bias: Bias
    """Standing errors of the features."""
    baseline: ScoreBaseline
    """Standing errors of the landmarker's scores."""
    reference: Reference
    """What the skin showed in the first frames."""
    motion: SkinMotion
    """How far the skin has moved."""
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
    breach: float = 0.0
    """Largest breach of the optimality conditions in the frame's box-constrained solves, relative; 0 = exact."""


def initial_state(context: TrackerContext) -> TrackState:
    """The state before the first frame: nothing is known yet."""
    model, config = context.model, context.config
    return TrackState(
        T_camera_face=Transform.identity(),
        vertices=model.neutral,
        weights=None,
        learner=IncrementalPca(model.neutral.size, config.pca),
        correctives=None,
        landmark_bias=no_bias(config.landmark_bias),
        baseline=no_baseline(model.shapes),
        reference=no_reference(len(model.front), config.fit.photometric),
        motion=no_motion(track.vertex_normals(model.neutral, model.faces)),
        lost=True,
        time=-np.inf,
    )
