"""Training clips: markers and registered high-resolution surfaces of the same frames (Ma et al. 2008, sec. 3, end)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..mesh import Mesh
from ..register import procrustes_frames


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


@dataclass(frozen=True)
class Aligned:
    """A frame with the head's motion taken out."""

    markers: Float[np.ndarray, "k 3"]
    """Face space, mm."""
    vertices: Float[np.ndarray, "n 3"]
    colors: Float[np.ndarray, "n 3"] | None


def aligned_markers(
    reference: Float[np.ndarray, "k 3"], positions: Float[np.ndarray, "frames k 3"]
) -> Float[np.ndarray, "frames k 3"]:
    """R(P): every frame brought onto the neutral's markers by its best rigid transform (sec. 4.1)."""
    T_neutral_frame = procrustes_frames(reference, positions).transform.inverse()
    return T_neutral_frame.apply(positions)


def aligned_frames(training: TrainingSet) -> Iterator[Aligned]:
    """Every frame of every clip, markers and surface under the same rigid transform.

    Raises:
        BadInput: a clip with fewer or more surfaces than marker frames, or of another topology.
    """
    for clip in training.clips:
        T_neutral_frame = procrustes_frames(training.markers, clip.markers).transform.inverse()
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
