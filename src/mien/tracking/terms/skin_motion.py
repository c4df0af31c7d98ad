"""How far a person's skin has moved of late, so that the head's pose is measured on what holds still (past the paper).

The weights of Beeler and Bradley 2014, but of the person as tracked so far, not of shapes that could be played: who
never raises the brows is held by the forehead, who frowns by the bridge of the nose.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32

MEMORY = 300.0
"""Frames after which a motion counts 1/e."""
STILL_MM = 0.3
"""Skin that has moved so far along its normal, root mean square, has half a say in the pose."""


@dataclass(frozen=True)
class SkinMotion:
    """What was seen of a front's motion."""

    normals: Float32[np.ndarray, "f 3"]
    """Of the neutral: along them depth would take the motion for the head's."""
    squares: Float32[np.ndarray, " f"]
    """Sum of squares of the motion along them, mm^2, that forgets."""
    frames: float
    """Frames in it, as far as they are not forgotten."""

    def pose_weights(self, share: Float32[np.ndarray, " f"]) -> Float32[np.ndarray, " f"]:
        """Each vertex's say, adding up to 1: its share of the area, less where it has moved."""
        mean = self.squares / np.float32(max(self.frames, 1.0) * STILL_MM**2)
        weights = share / (1 + mean)
        return weights / weights.sum()


def no_motion(normals: Float32[np.ndarray, "f 3"]) -> SkinMotion:
    """Nothing seen yet: all skin counts by its area."""
    return SkinMotion(normals, np.zeros(len(normals), np.float32), 0.0)


def learn_motion(motion: SkinMotion, displacement: Float32[np.ndarray, "f 3"]) -> SkinMotion:
    """Add a frame: the fitted face less its neutral, face space, mm."""
    keep = np.float32(np.exp(-1.0 / MEMORY))
    along = (displacement * motion.normals).sum(1)
    return SkinMotion(motion.normals, keep * motion.squares + along**2, float(keep) * motion.frames + 1.0)
