"""The front of a face laid out as it looks from straight ahead: pictures are compared there, whatever the pose."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8
from scipy.ndimage import binary_erosion

from ..._kernels import track_photo
from ...camera import Camera
from ...image_space.layout import sampled
from ...mesh import Mesh, vertex_normals
from ...pictures.raycast import depth_image
from ...transforms import Transform
from ..model import TrackingModel

FAR_MM = 1e5
"""The eye that looks at the chart is so far off that depth hardly shifts what it sees (0.1 mm in 100 mm)."""
STEEP = 3.0
"""Where the surface falls off by so many mm a mm it turns away, or hides something."""
BORDER_MM = 1.5
"""What lies nearer to that, or to the chart's border, is left out."""
HIDDEN_MM = 1.0
"""A vertex that lies deeper than what the chart shows in its place is not on the chart."""
LEAST_COSINE = 0.3
"""Skin seen at a smaller cosine to the line of sight shows too little."""
OCCLUDED_MM = 12.0
"""Depth so much nearer than the face is of something before it."""


@dataclass(frozen=True)
class FrontChart:
    """Which point of the front each pixel shows."""

    faces: Int[np.ndarray, "m 3"]
    """The front's triangles."""
    corners: Int[np.ndarray, "h w 3"]
    """The front's vertices round each pixel; 0 where there is none."""
    barycentric: Float[np.ndarray, "h w 3"]
    """Their weights; 0 where there is none."""
    inside: Bool[np.ndarray, "h w"]
    """Pixels that show the front, its border left out."""
    uv: Float[np.ndarray, "f 2"]
    """Where the front's vertices lie, pixels (x, y)."""
    shown: Bool[np.ndarray, " f"]
    """Vertices that the chart shows."""

    def drawn(self, values: Float[np.ndarray, "f 3"]) -> Float[np.ndarray, "h w 3"]:
        """Values of the vertices at every pixel; 0 where there is none."""
        return np.einsum("hwc,hwcd->hwd", self.barycentric, values[self.corners])

    def at_vertices(self, images: Float32[np.ndarray, "c h w"]) -> Float[np.ndarray, "f c"]:
        """Pixels' values where the vertices lie."""
        return sampled(np.moveaxis(images, 0, -1), self.uv)


def front_chart(model: TrackingModel, pixel_mm: float) -> FrontChart:
    """The front of the neutral on a chart of pixels `pixel_mm` wide."""
    neutral = model.neutral.astype(np.float64)
    low, high = neutral.min(axis=0), neutral.max(axis=0)
    width, height = (int(size) + 2 for size in np.ceil((high - low)[:2] / pixel_mm))
    focal = FAR_MM / pixel_mm
    camera = Camera(focal, focal, 0.5, 0.5, width, height)
    T = Transform(np.diag([1.0, -1.0, -1.0]), np.array([-low[0], high[1], FAR_MM + high[2]]))
    placed = T.apply(neutral)
    uv = camera.project(placed)
    seen = depth_image(Mesh(neutral, model.faces), camera, T)
    there = seen.faces >= 0
    inside = _away_from_edges(seen.depth, pixel_mm)
    column, row = np.rint(uv).astype(int).clip(0, [width - 1, height - 1]).T
    in_front = placed[:, 2] < seen.depth[row, column] + HIDDEN_MM
    return FrontChart(
        faces=model.faces,
        corners=np.where(there[..., None], model.faces[seen.faces], 0),
        barycentric=np.nan_to_num(seen.barycentric),
        inside=inside,
        uv=uv,
        shown=inside[row, column] & in_front,
    )


def _away_from_edges(depth: Float[np.ndarray, "h w"], pixel_mm: float) -> Bool[np.ndarray, "h w"]:
    """Pixels that show something, far enough from where nothing is shown or the surface turns away or leaps back."""
    slope = np.hypot(*np.gradient(depth))
    flat = slope < STEEP * pixel_mm
    return np.asarray(binary_erosion(flat, iterations=max(round(BORDER_MM / pixel_mm), 1)), dtype=bool)


@dataclass(frozen=True)
class ChartedFrame:
    """One frame's picture on the chart."""

    grey: Float[np.ndarray, "h w"]
    """Grey levels, 0..255; NaN where the front is not seen."""
    surface: Float[np.ndarray, "h w 3"]
    """The tracked front, face space, mm."""


def charted(
    chart: FrontChart,
    color: UInt8[np.ndarray, "rows columns 3"],
    depth: Float32[np.ndarray, "rows columns"] | None,
    camera: Camera,
    T_camera_face: Transform,
    vertices: Float[np.ndarray, "f 3"],
) -> ChartedFrame:
    """What a picture shows at every pixel of the chart, the front lying as it was tracked."""
    surface = chart.drawn(vertices)
    points = T_camera_face.apply(surface)
    normals = T_camera_face.rotate(chart.drawn(vertex_normals(vertices, chart.faces)))
    facing = -np.einsum("hwd,hwd->hw", normals, points)
    at = camera.project(points)
    turned = facing > LEAST_COSINE * np.linalg.norm(points, axis=-1)
    seen = chart.inside & turned & _in_picture(at, camera)
    if depth is not None:
        seen &= ~_occluded(depth, at, points[..., 2])
    shown = sampled(track_photo.grey(color).astype(np.float64), at)[..., 0]
    return ChartedFrame(np.where(seen, shown, np.nan), surface)


def _in_picture(at: Float[np.ndarray, "h w 2"], camera: Camera) -> Bool[np.ndarray, "h w"]:
    within = (at >= 0) & (at <= np.array([camera.width - 1, camera.height - 1]))
    return np.logical_and(within[..., 0], within[..., 1])


def _occluded(
    depth: Float32[np.ndarray, "rows columns"], at: Float[np.ndarray, "h w 2"], expected: Float[np.ndarray, "h w"]
) -> Bool[np.ndarray, "h w"]:
    """Where the sensor measures something before the face."""
    column = np.rint(at[..., 0]).astype(int).clip(0, depth.shape[1] - 1)
    row = np.rint(at[..., 1]).astype(int).clip(0, depth.shape[0] - 1)
    measured = depth[row, column]
    return (measured > 0) & (measured < expected - OCCLUDED_MM)
