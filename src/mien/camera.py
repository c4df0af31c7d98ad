"""The pinhole camera. OpenCV's frame: x right, y down, z forward; pixel centres at integers."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Camera:
    """Pinhole intrinsics, no lens distortion."""

    fx: float
    """Focal length, pixels."""
    fy: float
    cx: float
    """Principal point, pixels."""
    cy: float
    width: int
    height: int

    def project(self, points: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 2"]:
        """Camera space (mm) -> pixels. Points behind the camera give nonsense: test z first."""
        z = points[..., 2]
        return np.stack([self.fx * points[..., 0] / z + self.cx, self.fy * points[..., 1] / z + self.cy], -1)

    def rays(self, pixels: Float[np.ndarray, "*n 2"]) -> Float[np.ndarray, "*n 3"]:
        """Pixels -> directions with z = 1, so that `rays * depth` are points."""
        x = (pixels[..., 0] - self.cx) / self.fx
        y = (pixels[..., 1] - self.cy) / self.fy
        return np.stack([x, y, np.ones_like(x)], -1)

    def scaled(self, factor: float | int) -> "Camera":
        """The same view with `factor` times the pixels a side."""
        return Camera(
            fx=self.fx * factor,
            fy=self.fy * factor,
            cx=(self.cx + 0.5) * factor - 0.5,
            cy=(self.cy + 0.5) * factor - 0.5,
            width=round(self.width * factor),
            height=round(self.height * factor),
        )
