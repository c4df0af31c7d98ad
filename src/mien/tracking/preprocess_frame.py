"""What one frame shows the tracker: cleaned depth in a window round the face, landmarks as lines of sight."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32

from ..camera import Camera
from ..depth import RGBDFrame, Window, bilateral, window_around
from ..landmarks.detector import Landmarks2D


@dataclass(frozen=True)
class Sighting:
    """One frame, cropped and cleaned."""

    depth: Float32[np.ndarray, "h w"] | None
    """Millimetres, 0 = none; None where the take has no depth."""
    camera: Camera
    """Of the window's pixels."""
    sight: Float[np.ndarray, "478 2"] | None = None
    """Landmarks on the plane z = 1: x / z and y / z of the camera's space; None where no face was found."""
    said: Float[np.ndarray, " k"] | None = None
    """The landmarker's own expression scores, 0..1 at each of the rig's shapes; NaN where it has none."""

    @property
    def intrinsics(self) -> Float[np.ndarray, " 4"]:
        """fx, fy, cx, cy of the window."""
        c = self.camera
        return np.array([c.fx, c.fy, c.cx, c.cy])

    def moved(self, sight: Float[np.ndarray, "478 2"]) -> "Sighting":
        """The same with the landmarks elsewhere."""
        return replace(self, sight=sight)

    def without_landmarks(self) -> "Sighting":
        """The depth alone."""
        return replace(self, sight=None, said=None)


@dataclass(frozen=True)
class ObserveConfig:
    """Cropping and cleaning (Li et al. 2013, sec. 4.1)."""

    window: int = 200
    """Least side of the window round the face, pixels at 640 x 480; 0 = the whole image."""
    margin: int = 16
    """Pixels round the model's outline."""
    radius: int = 1
    """Half width of the smoothing window, pixels; 0 = no smoothing."""
    depth_sigma: float = 4.0
    """Steps larger than three times this, mm, are kept sharp."""


def observe(
    frame: RGBDFrame,
    camera: Camera,
    around: Float[np.ndarray, "n 2"] | None,
    landmarks: Landmarks2D | None,
    config: ObserveConfig = ObserveConfig(),
) -> Sighting:
    """Crop to the pixels `around` the model (None: all the image), smooth the depth, turn landmarks to sight lines."""
    window = Window(0, 0, camera.width, camera.height)
    if around is not None and config.window:
        window = window_around(around, camera, config.margin, config.window)
    depth = None
    if frame.depth is not None:
        depth = np.ascontiguousarray(window.crop(frame.depth))
        depth = bilateral(depth, config.radius, config.depth_sigma) if config.radius else depth
    sight = None if landmarks is None else camera.rays(landmarks.points)[:, :2]
    return Sighting(depth, window.camera(camera), sight)
