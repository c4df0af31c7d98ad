"""A face of known look before a sharp camera: every point of skin has its grey level, wherever it moves."""

from functools import cache

import numpy as np

import tracking_stage as stage
from mien.camera import Camera
from mien.pictures.raycast import depth_image
from mien.rig import Rig
from mien.tracking.relearn.front_chart import FrontChart, front_chart
from mien.tracking.relearn.skin_look import LookConfig
from mien.transforms import Transform

CAMERA = Camera(600.0, 600.0, 159.5, 119.5, 320, 240)
CONFIG = LookConfig(pixel_mm=1.25)


@cache
def chart() -> FrontChart:
    return front_chart(stage.model(), CONFIG.pixel_mm)


def look(skin: np.ndarray) -> np.ndarray:
    """Grey levels of points of the neutral, mm: freckles of two sizes."""
    x, y, z = np.moveaxis(skin, -1, 0)
    return 128 + 40 * np.sin(x / 2.1 + 0.3 * z) * np.sin(y / 2.6) + 40 * np.sin(x / 3.9 + y / 4.7)


def picture(rig: Rig, weights: np.ndarray, T_camera_face: Transform) -> tuple[np.ndarray, np.ndarray]:
    """Colour and depth."""
    mesh = rig.mesh(weights)
    seen = depth_image(mesh, CAMERA, T_camera_face)
    skin = np.einsum("hwc,hwcd->hwd", seen.barycentric, rig.neutral.vertices[mesh.faces[seen.faces]])
    grey = np.nan_to_num(look(skin), nan=30.0)
    color = np.repeat(np.rint(grey)[..., None], 3, axis=2).astype(np.uint8)
    return color, np.nan_to_num(seen.depth).astype(np.float32)
