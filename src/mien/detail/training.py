"""Training clips: markers and registered high-resolution surfaces of the same frames (Ma et al. 2008, sec. 3, end)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..mesh import Mesh
from ..register import procrustes_frames
from ..transforms import Transform

STEADY_MM = 0.3
"""A marker that is off by less than this on the head is as good as still."""
ROBUST_ROUNDS = 20
"""Of weighing a frame's markers by how far they are off; poses stand still after some ten."""
CAUTIOUS, STRICT = 1, 2
"""Powers of a marker's squared distance by which its say falls. From nothing known, 2 settles on a jaw or a brow."""


@dataclass(frozen=True)
class Frame:
    """One frame of a clip: the whole skin, in the mesh's vertex order."""

    vertices: Float[np.ndarray, "n 3"]
    """In the markers' frame of reference, mm; NaN where the frame does not show the skin."""
    colors: Float[np.ndarray, "n 3"] | None = None
    """Linear albedo, 0..1."""


@dataclass(frozen=True)
class Clip:
    """From neutral to an expression."""

    name: str
    markers: Float[np.ndarray, "frames k 3"]
    """Mm, complete: no gaps."""
    frames: Callable[[], Iterator[Frame]]
    """The surfaces, one a frame, made or read anew at each call: a set need not fit into memory."""


@dataclass(frozen=True)
class TrainingSet:
    """What maps are fitted to."""

    mesh: Mesh
    """Topology of the surfaces, at the neutral, with its detail; face space, mm."""
    markers: Float[np.ndarray, "k 3"]
    """The markers of that neutral, face space, mm."""
    labels: tuple[str, ...]
    clips: tuple[Clip, ...]

    def __post_init__(self):
        for clip in self.clips:
            if clip.markers.shape[1:] != self.markers.shape:
                raise BadInput(
                    f"{clip.name}: {clip.markers.shape[1]} markers where the neutral has {len(self.markers)}; "
                    "every clip of a training set carries the same markers"
                )
            if not np.isfinite(clip.markers).all():
                raise BadInput(f"{clip.name}: markers are missing; fill the gaps or leave the clip out")
        if not self.clips:
            raise BadInput("detail: no training clips")

    def __len__(self) -> int:
        return sum(len(clip.markers) for clip in self.clips)

    @cached_property
    def head(self) -> "HeadMarkers":
        """What tells the head's motion from the skin's."""
        return head_markers(self.markers, np.concatenate([clip.markers for clip in self.clips]))


@dataclass(frozen=True)
class HeadMarkers:
    """The neutral's markers, and how much each is asked where the head is."""

    reference: Float[np.ndarray, "k 3"]
    """Face space, mm."""
    steadiness: Float[np.ndarray, " k"]
    """1: still on the head; a marker of the jaw or a lip comes near 0."""

    def pose(self, positions: Float[np.ndarray, "frames k 3"]) -> Transform:
        """T_frame_neutral of every frame; NaN where a marker is missing."""
        return robust_pose(self.reference, positions, self.steadiness, STRICT)

    def aligned(self, positions: Float[np.ndarray, "frames k 3"]) -> Float[np.ndarray, "frames k 3"]:
        """R(P): every frame brought onto the neutral's markers (sec. 4.1)."""
        return self.pose(positions).inverse().apply(positions)


def head_markers(reference: Float[np.ndarray, "k 3"], positions: Float[np.ndarray, "frames k 3"]) -> HeadMarkers:
    """Markers weighed by their own motion^-4, so that an open jaw does not tilt the forehead.

    The paper's rigid fit asks all alike; what the mouth does then stands in every offset of the brow, and a brow
    without that mouth looks like nothing that was trained.
    """
    alike = np.ones(len(reference))
    moved = robust_pose(reference, positions, alike, CAUTIOUS).inverse().apply(positions)
    square = ((moved - reference) ** 2).sum(axis=2).mean(axis=0)
    weights = 1 / (square + STEADY_MM**2) ** 2
    return HeadMarkers(reference, weights / weights.max())


def robust_pose(
    reference: Float[np.ndarray, "k 3"], positions: Float[np.ndarray, "frames k 3"], say: Float[np.ndarray, " k"],
    power: int,
) -> Transform:  # fmt: skip
    """T_frame_reference of every frame: in each a marker's `say` is divided by (off^2 + `STEADY_MM`^2)^power."""
    weights = np.broadcast_to(say, positions.shape[:2])
    pose = procrustes_frames(reference, positions, weights).transform
    for _ in range(ROBUST_ROUNDS):
        square = ((pose.inverse().apply(positions) - reference) ** 2).sum(axis=2)
        weights = say * (STEADY_MM**2 / (square + STEADY_MM**2)) ** power
        pose = procrustes_frames(reference, positions, weights).transform
    return pose


@dataclass(frozen=True)
class Aligned:
    """A frame with the head's motion taken out."""

    markers: Float[np.ndarray, "k 3"]
    """Face space, mm."""
    vertices: Float[np.ndarray, "n 3"]
    colors: Float[np.ndarray, "n 3"] | None


def aligned_frames(training: TrainingSet, head: HeadMarkers | None = None) -> Iterator[Aligned]:
    """Every frame of every clip, markers and surface under the same rigid transform.

    Args:
        head: what finds it; the set's own where None.

    Raises:
        BadInput: a clip with fewer or more surfaces than marker frames, or of another topology.
    """
    head = head or training.head
    for clip in training.clips:
        T_neutral_frame = head.pose(clip.markers).inverse()
        moved = T_neutral_frame.apply(clip.markers)
        count = 0
        for count, frame in enumerate(clip.frames(), 1):
            if count > len(moved):
                break
            if frame.vertices.shape != training.mesh.vertices.shape:
                raise BadInput(
                    f"{clip.name}: frame {count - 1} has {len(frame.vertices):,} vertices where the neutral has "
                    f"{len(training.mesh.vertices):,}; surfaces of a training set share one topology"
                )
            yield Aligned(moved[count - 1], T_neutral_frame[count - 1].apply(frame.vertices), frame.colors)
        if count != len(moved):
            raise BadInput(f"{clip.name}: {len(moved)} frames of markers and not as many surfaces")
