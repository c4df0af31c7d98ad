"""Points that are right on the whole and normals that are right in detail become one surface (Nehab et al. 2005)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy import ndimage

from ..camera import Camera
from ..image_space.window import GaussianWindow
from ..solve.grid import GridSolution, solve_grid
from .integrate import STEEPEST, log_slopes, on_edges
from .normals import NormalMap
from .triangulate import DepthMap, pixel_rays, surface_normals

LEAN_PX = 3.0
"""Standard deviation of the window over which points are compared with a surface to tell how it leans, pixels."""
BROAD_PX = (1.0, 2.0, 4.0, 8.0)
"""Standard deviations of the Gaussians between which the breadth is interpolated beyond which points tell the shape."""


@dataclass(frozen=True)
class NormalFusionConfig:
    """How much of which source."""

    smooth_px: float = 12.0
    """Standard deviation of the smoothing beyond which geometry corrects normals, pixels. 0: it does not."""
    normal_sigma: float = 0.03
    """Standard deviation of a photometric normal where all is well, radians."""
    depth_sigma_mm: float = 0.08
    """Least standard deviation of a triangulated depth, mm: what calibration and blur leave, besides noise."""
    edge_mm: float = 4.0
    """Neighbours farther apart in depth are not joined."""
    least_trust: float = 0.05
    """A normal never counts less than this share of a sound one: else a crease would cut the surface in two."""
    differ: float = 0.1
    """A normal that differs by so much from that of the points counts a quarter, radians. 0: all count."""
    least_agreement: float = 0.02
    """But never less than this share."""
    shape_reach: int = 3
    """Pixels to either side over which the points' normals are taken for that."""
    hole_mm: float = 9.0
    """Holes in the points no wider or taller than this are bridged by normals: dots, specks. 0: none are."""
    uneven: float = 3.0
    """Depths' standard deviations are taken within this factor of their median."""
    lean: float = 0.005
    """Normals lean by so much or more to one side over a whole patch, radians: the shape of patches so broad that the
    mean of their points is known better than that is the points'. 0: it is as solved."""


@dataclass(frozen=True)
class Fused:
    """The surface that both sources agree on."""

    z: Float[np.ndarray, "h w"]
    """Along the first camera's axis, mm; NaN where no point was triangulated, but for small holes."""
    normals: Float[np.ndarray, "h w 3"]
    """Of that surface, camera space."""
    solution: GridSolution


def fuse(depth: DepthMap, light: NormalMap, camera: Camera, config: NormalFusionConfig = NormalFusionConfig()) -> Fused:
    """The most likely surface: depths with their variances, slopes of its logarithm with theirs.

    With q = log z the slopes are linear in the unknowns (`integrate.log_slopes`), so this is one sparse linear system.
    It takes errors for independent from pixel to pixel. Those of normals are not: they lean to one side over a cheek or
    a rim, and the surface with them. So the points' broad shape is put back, the more of it the more they lean
    (`with_broad`).
    """
    rays = pixel_rays(camera)
    geometry = surface_normals(np.where(steps_nearby(depth.z, config.edge_mm), np.nan, depth.z), camera)
    normals = corrected_normals(light, geometry, rays, config.smooth_px) if config.smooth_px else light.normals
    known = np.isfinite(depth.z)
    wanted = known | (small_holes(depth.z, camera, config.hole_mm) & light.known)
    toward = np.abs((np.nan_to_num(normals) * rays).sum(-1)) / np.linalg.norm(rays, axis=-1)
    slopes = log_slopes(np.where(wanted[..., None], normals, np.nan), camera, rays)
    trust = wanted * np.maximum(light.confidence**2 * toward**4, config.least_trust)
    trust = trust * agreement(normals, depth.z, camera, config)
    steps, edges = on_edges(slopes, trust * (camera.fx / config.normal_sigma) ** 2)
    q = np.log(np.where(known, depth.z, 1.0))
    parted = [np.abs(np.diff(depth.z, axis=axis)) > config.edge_mm for axis in (1, 0)]
    edges = (np.where(parted[0], 0.0, edges[0]), np.where(parted[1], 0.0, edges[1]))
    typical = float(np.nanmedian(depth.sigma_mm))
    noise = np.clip(np.nan_to_num(depth.sigma_mm, nan=typical), typical / config.uneven, typical * config.uneven)
    variance = (noise**2 + config.depth_sigma_mm**2) / np.where(known, depth.z, 1.0) ** 2
    weight = np.where(known, 1 / variance, 0.0)
    unit = weight[known].mean()
    solved = solve_grid(q, weight / unit, steps, (edges[0] / unit, edges[1] / unit))
    z = np.where(wanted, np.exp(solved.values), np.nan)
    if config.lean:
        z = with_broad(z, depth.z, broad_px(z, depth, camera, config))
    return Fused(z, surface_normals(z, camera), solved)


def broad_px(
    z: Float[np.ndarray, "h w"], depth: DepthMap, camera: Camera, config: NormalFusionConfig
) -> Float[np.ndarray, "h w"]:
    """Standard deviation of the Gaussian beyond which points tell the shape better than normals do, pixels.

    Over s pixels points' noise averages to noise / (2 sqrt(pi) s); normals that lean are off by lean * s * pixel.
    """
    noise = float(np.hypot(np.nanmedian(depth.sigma_mm), config.depth_sigma_mm))
    pixel_mm = float(np.nanmedian(depth.z)) / camera.fx
    lean = np.maximum(local_lean(z, depth.z, pixel_mm), config.lean)
    return np.sqrt(noise / (2 * np.sqrt(np.pi) * lean * pixel_mm))


def local_lean(
    z: Float[np.ndarray, "h w"], points: Float[np.ndarray, "h w"], pixel_mm: float
) -> Float[np.ndarray, "h w"]:
    """How the surface z leans beside points whose noise is evened out, root mean square round each pixel, radians; 0
    off the surface."""
    wanted = np.isfinite(z)
    off = np.where(wanted, blurred(points - z, wanted, LEAN_PX), np.nan)
    down, across = np.gradient(off / pixel_mm)
    square = np.asarray(down**2 + across**2)
    return np.sqrt(np.maximum(blurred(square, wanted, 2 * LEAN_PX), 0.0))


def with_broad(
    z: Float[np.ndarray, "h w"], points: Float[np.ndarray, "h w"], sigma_px: Float[np.ndarray, "h w"]
) -> Float[np.ndarray, "h w"]:
    """The surface z, its shape broader than a Gaussian of `sigma_px` taken from the points."""
    wanted, off = np.isfinite(z), points - z
    if not np.isfinite(off).any():
        return z
    place = np.log2(np.maximum(sigma_px, BROAD_PX[0]) / BROAD_PX[0])
    place = np.minimum(place, len(BROAD_PX) - 1)
    out = z.copy()
    for i, sigma in enumerate(BROAD_PX):
        share = np.maximum(1 - np.abs(place - i), 0.0)
        out += share * blurred(off, wanted, sigma)
    return out


def blurred(
    image: Float[np.ndarray, "h w"], wanted: Bool[np.ndarray, "h w"], sigma_px: float
) -> Float[np.ndarray, "h w"]:
    """Gaussian means of what is finite, at the pixels that are wanted; 0 elsewhere."""
    known = wanted & np.isfinite(image)
    values = image[known]
    sums = GaussianWindow(known, sigma_px).sums(np.stack([values, np.ones_like(values)], 1))
    out = np.zeros(image.shape)
    mean = sums[..., :1] / np.maximum(sums[..., 1:], 1e-6)
    out[wanted] = GaussianWindow(wanted, sigma_px).at_pixels(mean)[:, 0]
    return out


def agreement(
    normals: Float[np.ndarray, "h w 3"],
    z: Float[np.ndarray, "h w"],
    camera: Camera,
    config: NormalFusionConfig,
) -> Float[np.ndarray, "h w"]:
    """How far light's normals are to be believed beside the points', 1 where they agree or nothing is known.

    Near a rim skin mirrors the room, and light's normals lean by tens of degrees; the points do not.
    """
    if not config.differ:
        return np.ones(z.shape)
    shape = surface_normals(z, camera, config.shape_reach)
    cosine = np.clip((normals * shape).sum(-1), -1, 1)
    off = np.nan_to_num(np.arccos(cosine), nan=0.0)
    return np.maximum(1 / (1 + (off / config.differ) ** 2) ** 2, config.least_agreement)


def small_holes(z: Float[np.ndarray, "h w"], camera: Camera, hole_mm: float) -> Bool[np.ndarray, "h w"]:
    """Pixels of holes no larger than this, the surface all round them."""
    known = np.isfinite(z)
    if not known.any() or hole_mm <= 0:
        return np.zeros(z.shape, bool)
    most = hole_mm * camera.fx / float(np.nanmedian(z))
    labels = np.asarray(ndimage.label(~known)[0], dtype=np.int64)  # pyright: ignore[reportIndexIssue]
    sizes = [max(part.stop - part.start for part in box) for box in ndimage.find_objects(labels)]
    small = np.array([False, *(size <= most for size in sizes)])
    return small[labels]


def steps_nearby(z: Float[np.ndarray, "h w"], edge_mm: float) -> Bool[np.ndarray, "h w"]:
    """Pixels beside a step in depth."""
    known = np.isfinite(z)
    high = ndimage.maximum_filter(np.where(known, z, -np.inf), 3)
    return known & (high - ndimage.minimum_filter(np.where(known, z, np.inf), 3) > edge_mm)


def corrected_normals(
    light: NormalMap, geometry: Float[np.ndarray, "h w 3"], rays: Float[np.ndarray, "h w 3"], smooth_px: float
) -> Float[np.ndarray, "h w 3"]:
    """Photometric normals turned by the rotation from their smoothed selves to the smoothed normals of the geometry.

    Light from lamps that are not quite where they should be bends normals slowly over the face; geometry is right
    there (Nehab et al. 2005, sec. 3). Vectors of unit length along the ray are averaged, which are linear in slopes:
    means of unit normals would lean towards the camera where the geometry is noisy.
    """
    both = np.asarray(light.known & np.all(np.isfinite(geometry), axis=-1))
    if not both.any():
        return light.normals
    window = GaussianWindow(both, smooth_px)
    seen, ray = light.normals[both], rays[both]
    normals = light.normals.copy()
    normals[both] = turned(seen, _smoothed(seen, ray, window), _smoothed(geometry[both], ray, window))
    return normals


def _smoothed(normals: Float[np.ndarray, "p 3"], rays: Float[np.ndarray, "p 3"], window: GaussianWindow) -> np.ndarray:
    toward = np.abs((normals * rays).sum(-1, keepdims=True))
    blurred = window.at_pixels(window.sums(normals / np.maximum(toward, STEEPEST)))
    return blurred / np.maximum(np.linalg.norm(blurred, axis=-1, keepdims=True), 1e-12)


def turned(
    vectors: Float[np.ndarray, "*n 3"], source: Float[np.ndarray, "*n 3"], target: Float[np.ndarray, "*n 3"]
) -> Float[np.ndarray, "*n 3"]:
    """Vectors turned by the smallest rotation that takes `source` to `target` (unit vectors, not opposite)."""
    axis = np.cross(source, target)
    cosine = (source * target).sum(-1, keepdims=True)
    across = np.cross(axis, vectors)
    return vectors + across + np.cross(axis, across) / np.maximum(1 + cosine, 1e-6)
