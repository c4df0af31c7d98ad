"""What really happened on the stage. For scores alone: no solver may look at it."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from ..mesh import Attachment, Mesh
from ..transforms import Transform
from .people.performer import CHUNK, Performer
from .people.skin import Skin


@dataclass(frozen=True)
class Truth:
    """A performance as it was, whatever sensor recorded it."""

    actor: Performer | Skin
    weights: Float[np.ndarray, "frames shapes"]
    """What was performed: ARKit weights of the actor's own expressions."""
    T_lab_face: Transform
    """Head pose, one a frame; the lab is the markers' frame, or the colour camera's."""
    rate: float
    """Frames a second."""
    attachment: Attachment | None = None
    """Where each marker sits on the actor's mesh; None where there were none."""
    standoff: Float[np.ndarray, " markers"] | None = None
    """Marker centre above the skin, mm."""
    clean: Float[np.ndarray, "frames markers 3"] | None = None
    """Markers in the lab without any fault, mm."""
    in_view: Bool[np.ndarray, " frames"] | None = None
    """Whether the camera could see the face: neither out of the picture nor behind a hand. None for markers."""

    def __len__(self) -> int:
        return len(self.weights)

    @cached_property
    def neutral(self) -> Mesh:
        """The actor at rest in the bundled topology, face space, mm."""
        still = self._bundled(np.zeros((1, len(self.actor.names))))[0]
        return self._performer.neutral.with_vertices(still)

    def vertices(self, frames: Int[np.ndarray, " f"] | slice = slice(None)) -> Float[np.ndarray, "f n 3"]:
        """The actor at these frames in the bundled topology, face space, mm; computed anew at each call.

        Of a `Skin`, wrinkles and all; of what was cut off it, the performer underneath.
        """
        return self._bundled(self.weights[frames])

    def stream(self, frames: Int[np.ndarray, " f"], chunk: int = CHUNK) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """(frame numbers, vertices) in chunks."""
        for start in range(0, len(frames), chunk):
            yield frames[start : start + chunk], self.vertices(frames[start : start + chunk])

    @property
    def _performer(self) -> Performer:
        return self.actor.performer if isinstance(self.actor, Skin) else self.actor

    def _bundled(self, weights: np.ndarray) -> np.ndarray:
        if isinstance(self.actor, Performer):
            return self.actor.vertices(weights)
        out = self.actor.performer.vertices(weights)
        there = np.flatnonzero(self.actor.bundled >= 0)
        out[:, there] = self.actor.vertices(weights, self.actor.bundled[there])
        return out
