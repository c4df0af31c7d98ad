"""Pictures, with no display and no GPU: rays, shading, colour maps, sheets, films, charts."""

from .colormap import colors_of
from .occlusion import ambient_occlusion
from .plot import bar_chart, box_chart, line_chart
from .raycast import DepthImage, Hits, RayCaster, depth_image
from .render import Lamp, Look, Renderer, render
from .scale import scale_bar
from .sheet import contact_sheet, hstack, label, with_scale
from .video import write_mp4, write_png
from .view import View, frontal_camera

__all__ = [
    "DepthImage",
    "Hits",
    "Lamp",
    "Look",
    "RayCaster",
    "Renderer",
    "View",
    "ambient_occlusion",
    "bar_chart",
    "box_chart",
    "colors_of",
    "contact_sheet",
    "depth_image",
    "frontal_camera",
    "hstack",
    "label",
    "line_chart",
    "render",
    "scale_bar",
    "with_scale",
    "write_mp4",
    "write_png",
]
