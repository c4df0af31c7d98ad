"""Colour and depth from one moment, and what is done to a depth image before anything is fitted to it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8

from ._kernels import track_depth
from .camera import Camera
from .errors import BadInput
from .one_line import one_line


@dataclass(frozen=True)
class RGBDFrame:
    """One moment of a take: depth registered to colour, pixel by pixel, or one of the two alone."""

    color: UInt8[np.ndarray, "h w 3"] | None
    """sRGB; None where the sensor gives depth alone."""
    depth: Float32[np.ndarray, "rows columns"] | None
    """Millimetres along the camera's z; 0 or NaN where there is none. None for colour video."""
    time: float
    """Seconds since the take began."""

    def __repr__(self) -> str:
        seen = [image.shape for image in (self.color, self.depth) if image is not None]
        kinds = " and ".join(n for n, image in (("colour", self.color), ("depth", self.depth)) if image is not None)
        return one_line(self, f"{self.time:.3f} s", f"{kinds} of {seen[0][1]} x {seen[0][0]} pixels")

    def __post_init__(self):
        if not np.isfinite(self.time):
            raise BadInput(f"a frame's time is {self.time}; expected seconds since the take began")
        if self.color is None and self.depth is None:
            raise BadInput(f"the frame at {self.time:.3f} s has neither colour nor depth; record at least one of them")
        if self.color is not None and self.depth is not None and self.color.shape[:2] != self.depth.shape:
            (h, w), (dh, dw) = self.color.shape[:2], self.depth.shape
            raise BadInput(
                f"the frame at {self.time:.3f} s: colour is {w} x {h} and depth is {dw} x {dh} pixels; "
                "register depth to colour before recording"
            )


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels: the crop around the face (Li et al. 2013, sec. 4.1)."""

    x: int
    """First column."""
    y: int
    """First row."""
    width: int
    height: int

    def crop(self, image: np.ndarray) -> np.ndarray:
        """The window's pixels, a view."""
        return image[self.y : self.y + self.height, self.x : self.x + self.width]

    def camera(self, camera: Camera) -> Camera:
        """The camera whose whole image is this window."""
        return Camera(camera.fx, camera.fy, camera.cx - self.x, camera.cy - self.y, self.width, self.height)


def window_around(pixels: Float[np.ndarray, "n 2"], camera: Camera, margin: int = 20, least: int = 200) -> Window:
    """The smallest window inside the image round `pixels` with `margin` round them, `least` pixels a side or more.

    Pixels far outside the image give a window at its border.
    """
    limits = np.array([camera.width, camera.height])
    low, high = pixels.min(0) - margin, pixels.max(0) + margin
    grow = np.maximum(least - (high - low), 0) / 2
    low = np.clip(np.floor(low - grow), 0, limits - 1).astype(int)
    high = np.clip(np.ceil(high + grow), low + 1, limits).astype(int)
    return Window(int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


def valid(depth: Float32[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Where there is depth at all: neither 0 nor NaN."""
    return depth > 0


def unproject(depth: Float32[np.ndarray, "h w"], camera: Camera) -> Float32[np.ndarray, "h w 3"]:
    """Camera-space points of every pixel, mm; NaN where there is no depth."""
    z = np.where(depth > 0, depth, np.float32(np.nan))
    x = ((np.arange(camera.width) - camera.cx) / camera.fx).astype(np.float32)
    y = ((np.arange(camera.height) - camera.cy) / camera.fy).astype(np.float32)
    return np.stack([x[None, :] * z, y[:, None] * z, z], -1)


def normals_image(
    depth: Float32[np.ndarray, "h w"], camera: Camera, step: int = 2, jump: float = 20.0
) -> Float32[np.ndarray, "h w 3"]:
    """Unit normals in camera space, towards the camera; zero beside holes, borders and jumps of over `jump` mm.

    Differences are taken over `step` pixels each way: more is calmer, less is sharper.
    """
    return track_depth.normals(depth, camera.fx, camera.fy, camera.cx, camera.cy, step, np.float32(jump))


def bilateral(
    depth: Float32[np.ndarray, "h w"], radius: int = 2, depth_sigma: float = 4.0
) -> Float32[np.ndarray, "h w"]:
    """Smooth over (2 radius + 1)^2 pixels, but not over steps of more than 3 `depth_sigma` mm; 0 = no depth."""
    return track_depth.bilateral(depth, radius, np.float32(depth_sigma))


def median(depth: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "h w"]:
    """3 x 3 median of the pixels that have depth: takes away flying pixels. Holes stay holes."""
    return track_depth.median3(depth)
