"""What one frame shows the tracker: cleaned depth in a window round the face, landmarks as lines of sight."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32

from ..camera import Camera
from ..depth import RGBDFrame, Window, bilateral, window_around
from ..landmarks.detector import Landmarks2D
from .terms.photometric import PhotometricConfig, contrasts

ENOUGH = 0.5
"""Share of the landmarks that must be numbers for the others to be believed."""


@dataclass(frozen=True)
class FrameObservation:
    """One frame, cropped and cleaned."""

    depth: Float32[np.ndarray, "h w"] | None
    """Millimetres, 0 = none; None where the take has no depth."""
    camera: Camera
    """Of the window's pixels."""
    rays: Float[np.ndarray, "478 2"] | None = None
    """Landmarks on the plane z = 1: x / z and y / z of the camera's space, NaN for one that is not known; None where no
    face was found."""
    landmark_scores: Float[np.ndarray, " k"] | None = None
    """The landmarker's own expression scores, 0..1 at each of the rig's shapes; NaN where it has none."""
    contrast: tuple[Float32[np.ndarray, "h w"], ...] | None = None
    """The window's picture as `photometric.contrasts` makes it; None where there is no colour or no such term."""

    @property
    def intrinsics(self) -> Float[np.ndarray, " 4"]:
        """fx, fy, cx, cy of the window."""
        c = self.camera
        return np.array([c.fx, c.fy, c.cx, c.cy])

    def moved(self, rays: Float[np.ndarray, "478 2"]) -> "FrameObservation":
        """The same with the landmarks elsewhere."""
        return replace(self, rays=rays)

    def without_landmarks(self) -> "FrameObservation":
        """The depth alone."""
        return replace(self, rays=None, landmark_scores=None)


@dataclass(frozen=True)
class PreprocessFrameConfig:
    """Cropping and cleaning (Li et al. 2013, sec. 4.1)."""

    window: int = 200
    """Least side of the window round the face, pixels at 640 x 480; 0 = the whole image."""
    margin: int = 16
    """Pixels round the model's outline."""
    radius: int = 1
    """Half width of the smoothing window, pixels; 0 = no smoothing."""
    depth_sigma: float = 4.0
    """Steps larger than three times this, mm, are kept sharp."""


def preprocess_frame(
    frame: RGBDFrame,
    camera: Camera,
    around: Float[np.ndarray, "n 2"] | None,
    landmarks: Landmarks2D | None,
    config: PreprocessFrameConfig = PreprocessFrameConfig(),
    photometric: PhotometricConfig = PhotometricConfig(weight=0.0),
) -> FrameObservation:
    """Crop to the pixels `around` the model (None: all the image), smooth the depth, turn landmarks to sight lines."""
    window = Window(0, 0, camera.width, camera.height)
    if around is not None and config.window:
        window = window_around(around, camera, config.margin, config.window)
    depth = None
    if frame.depth is not None:
        depth = np.nan_to_num(window.crop(frame.depth), nan=0.0, posinf=0.0, neginf=0.0)
        depth = bilateral(depth, config.radius, config.depth_sigma) if config.radius else depth
    rays = None if landmarks is None else camera.rays(landmarks.points)[:, :2]
    contrast = None
    if frame.color is not None and photometric.weight:
        contrast = contrasts(np.ascontiguousarray(window.crop(frame.color)), photometric)
    return FrameObservation(depth, window.camera(camera), rays, contrast=contrast)


def usable(landmarks: Landmarks2D | None) -> Landmarks2D | None:
    """The landmarks if most of their points are finite, else None. Single points that are not count as unseen."""
    if landmarks is None:
        return None
    known = np.isfinite(landmarks.points).all(1) & np.isfinite(landmarks.depth)
    return landmarks if known.mean() >= ENOUGH else None


def scores_of(landmarks: Landmarks2D | None, names: tuple[str, ...]) -> Float[np.ndarray, " k"]:
    """What the landmarker says of each shape, 0..1; NaN where nothing, or nothing that is a score."""
    found = {} if landmarks is None else landmarks.scores
    scores = np.array([found.get(name, np.nan) for name in names])
    return np.where((scores >= 0) & (scores <= 1), scores, np.nan)
