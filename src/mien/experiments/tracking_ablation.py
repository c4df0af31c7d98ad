"""What each stage of the tracker is good for, and what it learns: one take, several trackers (figs. 5, 7, 11)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32

from ..landmarks.detector import FaceLandmarker, Landmarks2D
from ..landmarks.stream import Landmarker, with_landmarks
from ..progress import SILENT, Progress
from ..rgbd import RgbdTake
from ..tracking.adaptive import Subspace
from ..tracking.model import TrackingModel
from ..tracking.tracker import step_or_lose
from ..tracking.tracker_context import TrackConfig, TrackResult, initial_state, tracker_context
from ..transforms import Transform

FULL = "all stages"


def left_out(config: TrackConfig = TrackConfig()) -> dict[str, TrackConfig]:
    """The paper's fig. 5: the tracker whole, then with one stage left out, then rigid motion and blendshapes alone."""
    return {
        "blendshapes alone": replace(config, adaptive=False, correctives=False, output=False),
        "without adaptive space": replace(config, adaptive=False, correctives=False),
        "without correctives": replace(config, correctives=False),
        "without output deformation": replace(config, output=False),
        FULL: config,
    }


class Remembered:
    """A landmarker that looks at each moment of a take once; walked through again, it remembers."""

    def __init__(self, landmarker: Landmarker | None = None):
        self._landmarker = landmarker or FaceLandmarker("video")
        self.found: dict[float | None, Landmarks2D | None] = {}
        """By the frame's time, seconds."""

    def detect(self, image: np.ndarray, time: float | None = None) -> Landmarks2D | None:
        """The face in an RGB image, or None."""
        if time not in self.found:
            self.found[time] = self._landmarker.detect(image, time)
        return self.found[time]


@dataclass(frozen=True)
class Variant:
    """One tracker's way through a take."""

    T_camera_face: Transform
    """One a frame."""
    weights: Float[np.ndarray, "frames shapes"]
    """Solved anew on the final mesh."""
    front: Float32[np.ndarray, "frames f 3"]
    """Final vertices of the front, face space, mm."""


@dataclass(frozen=True)
class Ablation:
    """Several trackers over one take."""

    model: TrackingModel
    anchors: Subspace
    variants: dict[str, Variant]
    learnt: tuple[tuple[int, Subspace], ...]
    """(frame, correctives after it) of the whole tracker, now and then."""

    def vertices(self, name: str, frame: int) -> Float[np.ndarray, "n 3"]:
        """The whole rig's vertices in one frame, face space, mm."""
        variant = self.variants[name]
        return self.model.whole(variant.weights[frame], variant.front[frame].astype(np.float64))

    def known_by(self, frame: int) -> Subspace | None:
        """The correctives as they were before `frame`."""
        earlier = [space for at, space in self.learnt if at < frame]
        return earlier[-1] if earlier else None

    def outside(self, frame: int, correctives: Subspace | None) -> Float32[np.ndarray, "f 3"]:
        """What of the final mesh in `frame` the adaptive space with these correctives cannot say, mm."""
        moved = self.variants[FULL].front[frame] - self.model.neutral
        beyond = moved - self.anchors.project(moved)
        return beyond if correctives is None else beyond - correctives.project(beyond)


def compare(
    take: RgbdTake,
    model: TrackingModel,
    landmarker: Landmarker,
    configs: Mapping[str, TrackConfig],
    every: int = 3,
    progress: Progress = SILENT,
) -> Ablation:
    """Walk through a take once with several trackers side by side; `FULL` must be among `configs`.

    Args:
        every: after so many frames the correctives are kept.
    """
    contexts = {name: tracker_context(model, take.camera, config) for name, config in configs.items()}
    states = {name: initial_state(context) for name, context in contexts.items()}
    results: dict[str, list[TrackResult]] = {name: [] for name in configs}
    learnt: list[tuple[int, Subspace]] = []
    for i, (frame, landmarks) in enumerate(with_landmarks(take, landmarker)):
        for name, context in contexts.items():
            states[name], result = step_or_lose(context, frame, landmarks, states[name])
            results[name].append(result)
        correctives = states[FULL].correctives
        if correctives is not None and i % every == 0:
            learnt.append((i, correctives))
        progress.update("leaving stages out, one by one", i + 1, take.count)
    variants = {name: _variant(found) for name, found in results.items()}
    return Ablation(model, contexts[FULL].anchors, variants, tuple(learnt))


def _variant(results: list[TrackResult]) -> Variant:
    poses = [result.T_camera_face for result in results]
    return Variant(
        Transform(np.stack([T.rotation for T in poses]), np.stack([T.translation for T in poses])),
        np.stack([result.weights for result in results]),
        np.stack([result.vertices for result in results]),
    )
