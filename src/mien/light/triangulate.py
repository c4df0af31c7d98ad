"""Points from projector columns: between two cameras that see the same column, or between camera and projector."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from .._kernels import epipolar as kernel
from .._kernels._spread import spread
from ..camera import Camera
from ..errors import BadInput
from ..transforms import Transform
from .decode_sinusoids import Decoded
from .light_rig import RigView

LEAST_FOUND = 0.1
"""Share of one camera's decoded pixels that must find their column in the other."""
FACING_REACH = 2
"""Pixels to either side over which a point's slope is taken."""
PROJECTOR_ROUNDS = 3
"""How often a column is straightened again with the row that its point turned out to have."""


@dataclass(frozen=True)
class TriangulateConfig:
    """What counts as a point."""

    nearest_mm: float = 200.0
    """Of a point, along the first camera's axis."""
    farthest_mm: float = 3000.0
    """Likewise."""
    grazing: float = 0.17
    """Points are left out where the surface's normal and the line of sight have a smaller cosine (80 degrees)."""
    smallest_piece: int = 200
    """Pixels; smaller connected pieces are crumbs of wrong matches."""
    step_mm: float = 4.0
    """Neighbouring pixels farther apart in depth belong to different pieces."""


@dataclass(frozen=True)
class DepthMap:
    """Depth seen by the first camera, its pixels straightened."""

    z: Float[np.ndarray, "h w"]
    """Along the camera's axis, mm; NaN where nothing is known."""
    sigma_mm: Float[np.ndarray, "h w"]
    """Standard deviation that the patterns' noise gives it."""

    def points(self, camera: Camera) -> Float[np.ndarray, "h w 3"]:
        """In the camera's space, mm."""
        return pixel_rays(camera) * self.z[..., None]


def pixel_rays(camera: Camera) -> Float[np.ndarray, "h w 3"]:
    """Directions with z = 1 through all pixel centres."""
    x, y = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return camera.rays(np.stack([x, y], -1).astype(float))


@dataclass(frozen=True)
class RectifiedPair:
    """Two pinhole cameras turned so that a point lies on the same row of both."""

    left: Camera
    right: Camera
    R_rect_left: Float[np.ndarray, "3 3"]
    R_rect_right: Float[np.ndarray, "3 3"]
    baseline_mm: float
    """From left to right along x; negative where the one called left stands on the right."""


def rectify(left: RigView, right: RigView) -> RectifiedPair:
    """Turn both cameras about their centres: x along the baseline, z as near to their axes as can be.

    Raises:
        BadInput: cameras at one place, or behind one another.
    """
    T_left_right = left.T_view_rig @ right.T_view_rig.inverse()
    baseline = float(np.linalg.norm(T_left_right.translation))
    if baseline < 1.0:
        raise BadInput(f"calibration: {left.name} and {right.name} stand {baseline:.2f} mm apart; are they one camera?")
    x = T_left_right.translation / baseline * np.sign(T_left_right.translation[0] or 1.0)
    forward = np.array([0.0, 0.0, 1.0]) + T_left_right.rotation[:, 2]
    y = np.cross(forward, x)
    if np.linalg.norm(y) < 0.2:
        raise BadInput(f"calibration: {right.name} stands behind {left.name}; rows cannot be matched")
    y /= np.linalg.norm(y)
    R_rect_left = np.stack([x, y, np.cross(x, y)])
    R_rect_right = R_rect_left @ T_left_right.rotation
    focal = (left.camera.fy + right.camera.fy) / 2
    cameras = [_fitting(v.camera, R, focal) for v, R in ((left, R_rect_left), (right, R_rect_right))]
    above, below = max(c.cy for c in cameras), max(c.height - c.cy for c in cameras)
    made = [Camera(focal, focal, c.cx, above, c.width, int(np.ceil(above + below))) for c in cameras]
    toward = baseline * float(np.sign(x @ T_left_right.translation))
    return RectifiedPair(made[0], made[1], R_rect_left, R_rect_right, toward)


def _fitting(camera: Camera, R: np.ndarray, focal: float) -> Camera:
    """The turned camera, just large enough for all that the old one saw."""
    corners = np.array([[0, 0], [camera.width, 0], [0, camera.height], [camera.width, camera.height]], float) - 0.5
    turned = camera.rays(corners) @ R.T
    seen = focal * turned[:, :2] / turned[:, 2:]
    low, high = np.floor(seen.min(0)), np.ceil(seen.max(0))
    return Camera(focal, focal, -float(low[0]), -float(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


def resampled(
    image: Float[np.ndarray, "h w"], source: Camera, target: Camera, R_target_source: Float[np.ndarray, "3 3"]
) -> Float[np.ndarray, "hh ww"]:
    """An image of one camera as a turned one sees it; NaN where any of the four pixels is."""
    rays = pixel_rays(target) @ R_target_source
    where = source.project(rays)
    return ndimage.map_coordinates(image, [where[..., 1], where[..., 0]], order=1, cval=np.nan)


def triangulate_pair(
    left: RigView,
    right: RigView,
    seen_left: Decoded,
    seen_right: Decoded,
    config: TriangulateConfig = TriangulateConfig(),
) -> DepthMap:
    """Depth of the left camera's pixels, from equal projector columns along epipolar lines (sec. 3).

    The projector needs no calibration: both cameras see the same light. Strays are in it still (`cleaned`).

    Raises:
        BadInput: hardly any pixel finds its like.
    """
    pair = rectify(left, right)
    columns_left = resampled(seen_left.pixel, left.camera, pair.left, pair.R_rect_left)
    columns_right = resampled(seen_right.pixel, right.camera, pair.right, pair.R_rect_right)
    offset = pair.left.cx - pair.right.cx
    scale = pair.left.fx * pair.baseline_mm
    ends = sorted((scale / config.farthest_mm + offset, scale / config.nearest_mm + offset))
    disparity = np.empty_like(columns_left)
    crossings = np.zeros(columns_left.shape, np.int64)

    def rows(first: int, last: int) -> None:
        piece = slice(first, last)
        kernel.match_rows(
            columns_left[piece], columns_right[piece], ends[0], ends[1], disparity[piece], crossings[piece]
        )

    spread(rows, len(columns_left))
    known = np.isfinite(columns_left)
    found = np.isfinite(disparity).sum() / max(known.sum(), 1)
    if found < LEAST_FOUND:
        raise BadInput(
            f"only {found:.0%} of {left.name}'s pixels find their column in {right.name} "
            f"{config.nearest_mm:.0f} to {config.farthest_mm:.0f} mm away: "
            "are the two cameras' pictures swapped, or of another calibration?"
        )
    turned = scale / (disparity - offset)
    slope = np.abs(np.gradient(columns_left, axis=1))
    blur = resampled(seen_left.sigma, left.camera, pair.left, pair.R_rect_left) / np.maximum(slope, 1e-6) * np.sqrt(2)
    sigma = turned**2 / abs(scale) * blur
    return _at_pixels(turned, sigma, pair, left.camera)


def _at_pixels(turned: np.ndarray, sigma: np.ndarray, pair: RectifiedPair, camera: Camera) -> DepthMap:
    """From the turned camera's grid to the camera's own: nearness is interpolated, since it is linear on a plane."""
    rays = pixel_rays(camera) @ pair.R_rect_left.T
    where = pair.left.project(rays)
    at = [where[..., 1], where[..., 0]]
    z = rays[..., 2] ** -1 / ndimage.map_coordinates(1 / turned, at, order=1, cval=np.nan)
    return DepthMap(z, ndimage.map_coordinates(sigma, at, order=1, cval=np.nan))


def triangulate_projector(
    view: RigView,
    projector: RigView,
    seen: Decoded,
    config: TriangulateConfig = TriangulateConfig(),
    rows: Decoded | None = None,
) -> DepthMap:
    """Depth of one camera's pixels from the planes of light that the calibrated projector's columns are.

    Args:
        rows: of the projector, where its patterns tell those too: a projector above the camera needs them, and each
            pixel has its point where both planes fit best.

    Raises:
        BadInput: no point lies within the distances of `config`.
    """
    T_projector_view = projector.T_view_rig @ view.T_view_rig.inverse()
    rays = pixel_rays(view.camera)
    if rows is None:
        straight, told = straight_columns(rays, T_projector_view, projector, seen.pixel)[..., None], [seen]
    else:
        straight, told = projector.undistorted(np.stack([seen.pixel, rows.pixel], -1)), [seen, rows]
    planes = [_plane(rays, T_projector_view, projector.camera, straight[..., axis], axis) for axis in range(len(told))]
    z, sigma = _meet(rays, T_projector_view, planes, [decoded.sigma for decoded in told])
    return cleaned(DepthMap(z, sigma), view.camera, config)


def straight_columns(
    rays: Float[np.ndarray, "h w 3"], T_projector_view: Transform, projector: RigView, columns: Float[np.ndarray, "h w"]
) -> Float[np.ndarray, "h w"]:
    """Columns of the projector without its lens's distortion, which depends on the row that each point lies in."""
    straight = columns
    for _ in range(PROJECTOR_ROUNDS if any(projector.distortion) else 0):
        a, b = _plane(rays, T_projector_view, projector.camera, straight, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            points = T_projector_view.apply((rays * (b / a)[..., None]).reshape(-1, 3)).reshape(rays.shape)
        row = projector.distorted(projector.camera.project(points))[..., 1]
        straight = projector.undistorted(np.stack([columns, row], -1))[..., 0]
    return straight


def _plane(
    rays: np.ndarray, T: Transform, projector: Camera, pixel: np.ndarray, axis: int
) -> tuple[np.ndarray, np.ndarray]:
    """a z = b along each ray where it meets the plane of a projector's column (axis 0) or row (axis 1)."""
    focal, centre = ((projector.fx, projector.cx), (projector.fy, projector.cy))[axis]
    across, along = rays @ T.rotation[axis], rays @ T.rotation[2]
    off = pixel - centre
    return off * along - focal * across, focal * T.translation[axis] - off * T.translation[2]


def _meet(rays: np.ndarray, T: Transform, planes: list, sigmas: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Depth along each ray that all planes agree on best, and its standard deviation."""
    top, bottom = np.zeros(rays.shape[:2]), np.zeros(rays.shape[:2])
    for (a, b), sigma in zip(planes, sigmas, strict=True):
        top = top + a * b / sigma**2
        bottom = bottom + (a / sigma) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        z = top / bottom
        away = z * (rays @ T.rotation[2]) + T.translation[2]
        return z, np.abs(away) / np.sqrt(bottom)


def cleaned(depth: DepthMap, camera: Camera, config: TriangulateConfig) -> DepthMap:
    """Without what is too near, too far, seen at a grazing angle, or a crumb.

    Raises:
        BadInput: all of it is too near or too far.
    """
    z = np.where((depth.z > config.nearest_mm) & (depth.z < config.farthest_mm), depth.z, np.nan)
    if np.isfinite(depth.z).any() and not np.isfinite(z).any():
        raise BadInput(
            f"points lie {np.nanmedian(depth.z):.0f} mm away, none of them within {config.nearest_mm:.0f} to "
            f"{config.farthest_mm:.0f} mm: set --triangulate.nearest-mm and --triangulate.farthest-mm, "
            "or is the calibration of another rig?"
        )
    z = np.where(facing(z, camera) > config.grazing, z, np.nan)
    z = np.where(pieces(z, config.step_mm) >= config.smallest_piece, z, np.nan)
    return DepthMap(z, np.where(np.isfinite(z), depth.sigma_mm, np.nan))


def facing(z: Float[np.ndarray, "h w"], camera: Camera) -> Float[np.ndarray, "h w"]:
    """Cosine of the angle between the surface's normal and the line of sight; 1 where there is no normal.

    A depth map's normals are noisier than it is, so they are taken over a window of 5 pixels.
    """
    rays = pixel_rays(camera)
    normals = surface_normals(z, camera, FACING_REACH)
    cosine = np.abs((normals * rays).sum(-1)) / np.linalg.norm(rays, axis=-1)
    return np.where(np.isfinite(cosine), cosine, 1.0)


def surface_normals(z: Float[np.ndarray, "h w"], camera: Camera, reach: int = 1) -> Float[np.ndarray, "h w 3"]:
    """Unit normals of a depth map, towards the camera, from points `reach` pixels to either side.

    One-sided where the other side is unknown; NaN where neither is known.
    """
    points = pixel_rays(camera) * z[..., None]
    tangents = []
    for axis in (1, 0):
        ahead, behind = np.roll(points, -reach, axis), np.roll(points, reach, axis)
        ahead = np.where(np.isfinite(ahead), ahead, points)
        behind = np.where(np.isfinite(behind), behind, points)
        tangents.append(ahead - behind)
    normal = np.cross(tangents[1], tangents[0])
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(length > 0, normal / length, np.nan)


def pieces(z: Float[np.ndarray, "h w"], step_mm: float) -> Float[np.ndarray, "h w"]:
    """For every pixel, how many pixels its connected piece of surface has; 0 where nothing is known.

    Pixels beside a jump of depth are taken out before pieces are counted, and given back to the piece they touch.
    """
    known = np.isfinite(z)
    filled = np.where(known, z, 0.0)
    low = ndimage.minimum_filter(np.where(known, z, np.inf), 3)
    high = ndimage.maximum_filter(np.where(known, z, -np.inf), 3)
    calm = known & (high - filled < step_mm) & (filled - low < step_mm)
    labels = np.asarray(ndimage.label(calm)[0], dtype=np.int64)  # pyright: ignore[reportIndexIssue]
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    grown = ndimage.maximum_filter(sizes[labels], 3)
    return np.where(known, grown, 0).astype(float)
