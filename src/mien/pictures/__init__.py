"""Pictures, with no display and no GPU: rays, shading, colour maps, sheets, films, charts, reports."""

from .raycast import DepthImage, Hits, RayCaster, depth_image
from .render import Lamp, Look, Renderer, render
from .view import View, frontal_camera

__all__ = [
    "DepthImage",
    "Hits",
    "Lamp",
    "Look",
    "RayCaster",
    "Renderer",
    "View",
    "depth_image",
    "frontal_camera",
    "render",
]
