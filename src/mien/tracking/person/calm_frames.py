"""The frames of a take that a person's neutral face is made from, and how neutral the landmarker finds them."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from jaxtyping import Float

from ...depth import RGBDFrame
from ...errors import BadInput
from ...landmarks.detector import Landmarks2D
from ...landmarks.stream import Landmarker, with_landmarks
from ...one_line import count
from ...progress import Progress
from ...rgbd import RgbdTake
from ..detect import WrongScale, length

PATIENCE = 30
"""Frames in which a face must appear."""
USUAL_SCALES = (100, 1000, 2000, 4000, 5000, 8000, 10000)
"""Units a metre that depth cameras and data sets use."""
SAME_SCALE = 0.2
"""A usual scale is meant where the wanted one differs by less, in natural logarithms."""
TELLING = (
    "mouthSmileLeft", "mouthSmileRight", "jawOpen", "mouthFunnel", "mouthUpperUpLeft", "mouthUpperUpRight",
    "mouthLowerDownLeft", "mouthLowerDownRight", "browDownLeft", "browDownRight",
)  # fmt: skip
"""Expressions that the landmarker hardly scores on faces at rest (0.1 at most on staged ones): there it is believed."""
EXPRESSIVE = 0.2
"""A score of these above which a face is told to be no neutral one."""
RELAXING = 0.15
"""Frames whose scores lie above the calmest frame's by more than this are left out: it was coming to rest."""
FEWEST = 5
"""So many calm frames are kept, however expressive."""


@dataclass(frozen=True)
class Neutrality:
    """How neutral the frames are that the neutral face was made from."""

    first: int
    """The first of them, from 0."""
    last: int
    left_out: int
    """Frames between them in which the face was still moving into its rest."""
    name: str
    """The expression that the landmarker scores highest there, of those that it does not score at rest."""
    score: float
    """Its median score, 0..1."""

    @property
    def neutral(self) -> bool:
        """Whether the face is neutral there, as far as the landmarker can tell."""
        return self.score < EXPRESSIVE

    def __str__(self) -> str:
        where = f"frames {self.first} to {self.last}"
        if self.neutral:
            return f"the neutral is {where}: at most {self.name} {self.score:.2f} there"
        return (
            f"the neutral, {where}, is none: the landmarker sees {self.name} {self.score:.2f} there, and expressions "
            "will be relative to it (--neutral names other frames)"
        )


def calm_frames(
    take: RgbdTake, landmarker: Landmarker, first: int, most: int, progress: Progress
) -> tuple[list[RGBDFrame], list[Landmarks2D], Neutrality]:
    """Up to `most` frames from `first` on in which a face is found and at rest, their landmarks, how neutral they are.

    Raises:
        BadInput: the take ends before, or there is no face in its first 30 frames from there.
    """
    frames, found, numbers = [], [], []
    window = islice(iter(take), first, first + most)
    for i, (frame, landmarks) in enumerate(with_landmarks(window, landmarker)):
        if landmarks is not None:
            frames.append(frame)
            found.append(landmarks)
            numbers.append(first + i)
        if i + 1 >= PATIENCE and not frames:
            break
        progress.update("looking for the face", i + 1, min(most, take.count))
    if not frames:
        raise no_face(take, first)
    scores = telling_scores(found)
    kept = resting_frames(scores.max(1))
    neutrality = judged(scores[kept], [numbers[i] for i in kept], len(frames) - len(kept))
    return [frames[i] for i in kept], [found[i] for i in kept], neutrality


def telling_scores(found: Sequence[Landmarks2D]) -> Float[np.ndarray, "frames telling"]:
    """Scores of the expressions that are not scored at rest, 0..1."""
    scores = np.array([[marks.scores.get(name, 0.0) for name in TELLING] for marks in found])
    return np.clip(np.nan_to_num(scores), 0.0, 1.0)


def resting_frames(strength: Float[np.ndarray, " frames"]) -> list[int]:
    """Frames about as calm as the calmest, in their order: a smile that fades is not merged into the face."""
    calm = np.flatnonzero(strength <= strength.min() + RELAXING)
    if len(calm) < FEWEST:
        calm = np.sort(np.argsort(strength, kind="stable")[:FEWEST])
    return calm.tolist()


def judged(scores: Float[np.ndarray, "frames telling"], numbers: Sequence[int], left_out: int) -> Neutrality:
    """How neutral frames with these scores and numbers are."""
    typical = np.median(scores, axis=0)
    worst = int(typical.argmax())
    return Neutrality(numbers[0], numbers[-1], left_out, TELLING[worst], float(typical[worst]))


def no_face(take: RgbdTake, first: int = 0) -> BadInput:
    """The line for a take without a face in the frames from `first` on."""
    if first:
        return BadInput(f"{take.name}: no face from frame {first} on; --neutral must name frames that show it")
    where = f"the first {PATIENCE} frames" if take.count > PATIENCE else f"any of its {count(take.count, 'frames')}"
    return BadInput(f"{take.name}: no face in {where}; face the camera, in light, and start again")


def with_scale(error: BadInput, take: RgbdTake) -> BadInput:
    """The error, and if it is about the depth's unit, which scale would fit this take."""
    if not isinstance(error, WrongScale) or take.depth_scale is None:
        return error
    wanted = take.depth_scale * error.factor
    usual = min(USUAL_SCALES, key=lambda scale: abs(np.log(scale / wanted)))
    wanted = usual if abs(np.log(usual / wanted)) < SAME_SCALE else round(wanted)
    wide = length(error.wide * take.depth_scale / wanted)
    return BadInput(
        f"{take.name}: with {take.depth_scale:g} units of depth a metre the face is {length(error.wide)} wide; "
        f"--depth-scale {wanted} would make it {wide}"
    )
