"""A take becomes a performance (Li et al. 2013, fig. 4): the paper's steps are in `tracker.step`, here is the loop."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Float

from ..depth import RGBDFrame
from ..errors import BadInput
from ..faces.arkit import ARKIT_NAMES
from ..landmarks.detector import FaceLandmarker, Landmarks2D
from ..landmarks.on_rig import LandmarkMap, landmarks_of
from ..landmarks.stream import Landmarker, with_landmarks
from ..one_line import one_line
from ..progress import SILENT, Progress
from ..rgbd import RgbdTake
from ..rig import Performance, Rig
from ..rig.facs import FACS23
from ..transforms import Transform
from .correctives import CorrectiveBasis, CorrectiveConfig, with_correctives
from .hidden.lower_face import lower_face_config, lower_face_model, with_upper_shapes
from .model import TrackingModel, tracking_model
from .person.calm_frames import PATIENCE, no_face, with_scale
from .relearn.relearn_shapes import FirstPass, RelearnConfig, relearn_shapes
from .terms.fit_config import BlendshapeFitConfig, colour_alone
from .tracker import step_or_lose
from .tracker_context import NoTimer, StageTimer, TrackConfig, TrackResult, initial_state, tracker_context

T_WORLD_CAMERA = Transform(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
"""The take's world is the colour camera turned to +Y up, -Z forward."""


@dataclass(frozen=True)
class TrackTakeConfig:
    """Tracking a whole take."""

    track: TrackConfig = field(default_factory=TrackConfig)
    video: BlendshapeFitConfig = field(default_factory=colour_alone)
    """The blendshape fit where there is no depth."""
    correctives: CorrectiveConfig = field(default_factory=CorrectiveConfig)
    relearn: RelearnConfig = field(default_factory=RelearnConfig)
    """More passes, with shapes relearnt from the one before; not for a live source, a hidden face or colour alone."""
    hidden: Literal["upper"] | None = None
    """What a headset hides: the upper face, whose skin, landmarks and shapes are then left out; None: nothing."""
    late: bool = False
    """Take the landmarks of the frame before, as a live source must."""
    live: bool = False
    """Frames come by the clock: landmarks are late, and frames that came while the tracker was busy, which the times of
    the others tell, hold the last value."""


@dataclass(frozen=True)
class Tracked:
    """A tracked take."""

    performance: Performance
    """The rig's shapes, then corrective shapes that make up the difference to the final mesh."""
    fitted: Float[np.ndarray, "frames shapes"]
    """Coefficients of the initial blendshape fit."""
    errors: Float[np.ndarray, " frames"]
    """Mean point-to-plane distance after the rigid step, mm; NaN where lost, or without depth."""
    to_anchors: Float[np.ndarray, " frames"]
    """Distance of the final mesh from the anchor space, mm rms (fig. 11, green)."""
    to_adaptive: Float[np.ndarray, " frames"]
    """Distance from the adaptive space before the frame was learnt from, mm rms (fig. 11, blue)."""
    learnt: int
    """Samples that the correctives were learnt from."""
    stopped: str | None
    """Why the take ended early; None where it was read to its end."""
    missed: int = 0
    """Frames of a live source that came while the tracker was busy: they hold the last value."""

    def __repr__(self) -> str:
        off = f"mean distance {np.nanmean(self.errors):.2f} mm" if np.isfinite(self.errors).any() else ""
        return one_line(self, self.performance, off, self.stopped)


def track_take(
    take: RgbdTake,
    rig: Rig,
    landmarks: LandmarkMap | None = None,
    landmarker: Landmarker | None = None,
    config: TrackTakeConfig = TrackTakeConfig(),
    progress: Progress = SILENT,
    timer: StageTimer = NoTimer(),
    watch: Callable[[TrackResult], None] | None = None,
) -> Tracked:
    """Track a take on a person's rig.

    Args:
        landmarks: where they are on the rig, from `personalize`; found by looking at the rig if not given.
        watch: hears every frame's outcome as it comes; those of later passes as well.

    Raises:
        BadInput: a rig without expression shapes, no face in the first 30 frames, a depth scale that makes no face, or
            a first frame that cannot be read. A take that breaks off later gives what was tracked, and `stopped`.
    """
    check_shapes(rig)
    marks = landmarks or landmarks_of(rig)
    looking = landmarker or FaceLandmarker("video")
    late = config.late or config.live
    told: list[Landmarks2D | None] = []
    seen = _remembered(with_landmarks(take, looking, late=late), told)
    model = lower_face_model(rig, marks) if config.hidden else tracking_model(rig, marks)
    found = _walked(take, model, seen, config, progress, timer, watch)
    if config.hidden:
        return replace(found, performance=with_upper_shapes(found.performance, rig))
    if config.live or not take.has_depth:
        return found
    in_use = config.track.fit.in_use

    def once_more(model: TrackingModel, before: Tracked) -> Tracked:
        dearer = model.dearer_where_idle(before.fitted, in_use)
        again = zip(take, told, strict=False)
        return _walked(take, dearer, again, config, progress, timer, watch, "tracking once more")

    if in_use:
        found = once_more(model, found)
    for _ in range(config.relearn.rounds):
        last = FirstPass(take, model, found.performance, found.fitted, T_WORLD_CAMERA)
        relearnt = relearn_shapes(last, config.relearn, progress)
        if relearnt is model.rig:
            break
        model = tracking_model(relearnt, marks)
        found = once_more(model, found)
    return found


def _walked(
    take: RgbdTake,
    model: TrackingModel,
    seen: Iterator[tuple[RGBDFrame, Landmarks2D | None]],
    config: TrackTakeConfig,
    progress: Progress,
    timer: StageTimer,
    watch: Callable[[TrackResult], None] | None,
    stage: str = "tracking",
) -> Tracked:
    """One walk through the take, which progress calls `stage`."""
    times: list[float] = []
    walk = track_frames(model, take, _timed(seen, times), config, timer)
    kept = _Results(CorrectiveBasis(model, config.correctives))
    stopped = None
    try:
        for result in walk:
            if config.live:
                kept.hold(_missed(times, len(kept), take))
            kept.add(result, model)
            if watch is not None:
                watch(result)
            progress.update(stage, len(kept), take.count)
    except BadInput as error:
        if not kept.tracked.any():
            raise with_scale(error, take) from error
        stopped = str(error)
    return _collect(take, model, kept, stopped)


def track_frames(
    model: TrackingModel,
    take: RgbdTake,
    seen: Iterator[tuple[RGBDFrame, Landmarks2D | None]],
    config: TrackTakeConfig = TrackTakeConfig(),
    timer: StageTimer = NoTimer(),
) -> Iterator[TrackResult]:
    """Frame by frame, as they come: for a live source, or for whoever wants more than the performance.

    Raises:
        BadInput: no face in the first 30 frames.
    """
    track = config.track if take.has_depth else replace(config.track, fit=config.video)
    track = lower_face_config(track) if config.hidden else track
    late = config.late or config.live
    context = tracker_context(model, take.camera, track, timer)
    state, ever = initial_state(context), False
    for i, (frame, landmarks) in enumerate(seen):
        state, result = step_or_lose(context, frame, landmarks, state, late=late)
        ever |= result.tracked
        if not ever and i + 1 >= PATIENCE:
            raise no_face(take)
        yield result


def check_shapes(rig: Rig, name: str = "the rig") -> None:
    """See that the rig, called `name`, has expressions.

    Raises:
        BadInput: none that is known by name.
    """
    if not set(rig.names) & {*ARKIT_NAMES, *FACS23}:
        told = ", ".join(rig.names[:4]) or "no shapes at all"
        raise BadInput(
            f"{name} has none of the ARKit shapes (it has {told}); make one with `mien personalize`, or rename these"
        )


def _remembered(seen: Iterator, told: list[Landmarks2D | None]) -> Iterator:
    """The same, each frame's landmarks noted."""
    for frame, landmarks in seen:
        told.append(landmarks)
        yield frame, landmarks


def _timed(seen: Iterator, times: list[float]) -> Iterator:
    """The same, each frame's time noted as it is asked for."""
    for frame, landmarks in seen:
        times.append(frame.time)
        yield frame, landmarks


def _missed(times: list[float], done: int, take: RgbdTake) -> int:
    """Frames that came and went between the last result and this one, by the clock."""
    return max(round((times[-1] - times[0]) * take.rate) - done, 0) if done else 0


@dataclass(frozen=True)
class _Kept:
    """What is kept of a frame."""

    tracked: bool
    T_camera_face: Transform
    fitted: np.ndarray
    weights: np.ndarray
    numbers: tuple[float, float, float]
    learnt: bool


class _Results:
    """What is kept of the frames so far."""

    def __init__(self, residuals: CorrectiveBasis):
        self.residuals = residuals
        self.missed = 0
        self._frames: list[_Kept] = []
        self._offset = np.zeros(0)

    def __len__(self) -> int:
        return len(self._frames)

    def add(self, result: TrackResult, model: TrackingModel) -> None:
        """Keep a frame; what its blendshapes do not say of its mesh is a residual."""
        self._offset = result.vertices - model.blend(result.weights)
        self.residuals.add(self._offset)
        numbers = (result.error, result.to_anchors, result.to_adaptive)
        pose = result.T_camera_face
        self._frames.append(_Kept(result.tracked, pose, result.fitted, result.weights, numbers, result.learnt))

    def hold(self, missed: int) -> None:
        """Repeat the last frame for frames that were not looked at."""
        for _ in range(missed):
            self.missed += 1
            self.residuals.add(self._offset)
            self._frames.append(replace(self._frames[-1], tracked=False))

    @property
    def tracked(self) -> np.ndarray:
        """Mask of the frames."""
        return np.array([frame.tracked for frame in self._frames], dtype=bool)

    @property
    def learnt(self) -> int:
        """Frames that the correctives were learnt from."""
        return sum(frame.learnt for frame in self._frames)

    def stacked(self, what: str) -> np.ndarray:
        """A field of every frame."""
        return np.stack([getattr(frame, what) for frame in self._frames])

    def T_world_face(self) -> Transform:
        """The head in every frame; before it was first found, where it was found."""
        rotation = np.stack([frame.T_camera_face.rotation for frame in self._frames])
        translation = np.stack([frame.T_camera_face.translation for frame in self._frames])
        first = int(self.tracked.argmax())
        rotation[:first] = rotation[first]
        translation[:first] = translation[first]
        turn = T_WORLD_CAMERA.rotation
        return Transform(turn @ rotation, translation @ turn.T)


def _collect(take: RgbdTake, model: TrackingModel, kept: _Results, stopped: str | None) -> Tracked:
    if not kept.tracked.any():
        raise no_face(take)
    shapes, more = kept.residuals.finish()
    more = more if len(more) else np.zeros((len(kept), 0))
    rig = with_correctives(model.rig, model, shapes)
    weights = np.concatenate([kept.stacked("weights"), more], 1)
    performance = Performance(rig, weights, kept.T_world_face(), take.rate, kept.tracked)
    errors, to_anchors, to_adaptive = kept.stacked("numbers").T
    return Tracked(
        performance=performance,
        fitted=kept.stacked("fitted"),
        errors=errors,
        to_anchors=to_anchors,
        to_adaptive=to_adaptive,
        learnt=kept.learnt,
        stopped=stopped,
        missed=kept.missed,
    )
