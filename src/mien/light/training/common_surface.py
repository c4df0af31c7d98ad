"""One texture space for the scans of a face: each of its points found again in every scan (Ma et al. 2008, sec. 3)."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import ndimage

from ...errors import BadInput
from ...flow import FlowConfig, optical_flow
from ...mesh import Mesh, closest_point, grid_faces, vertex_normals
from ...register import procrustes
from ...register.interpolate import interpolate_from_points
from ..disk.light_scan import LightScan
from ..light_rig import RigView
from .dots import masked_blur, pixel_mm

ALONG_NORMALS = 5
"""Rounds in which points go along their normals to a scan; each divides what is left by three or more."""


@dataclass(frozen=True)
class CommonConfig:
    """How the texture space is laid out and scans are brought into it."""

    grid_mm: float = 0.8
    """Distance of neighbouring points on the skin; the camera's pixels where they are larger."""
    longest: float = 4.0
    """Neighbours farther apart than this many grid steps are not joined."""
    reach_mm: float = 60.0
    """A dot's motion fades beyond about so far from it."""
    carry_vertices: int = 6000
    """A dot's motion is carried over a grid of about so many, and between them by straight lines."""
    farthest_mm: float = 8.0
    """Skin farther from where the dots put it is other skin."""
    relief_mm: float = 3.0
    """Standard deviation of the blur that is taken off the surface: what is left is its displacement map."""
    refine: bool = True
    """Align displacement maps by optical flow, after the dots."""
    least_relief_mm: float = 0.02
    """Displacements are compared as multiples of their root mean square, or of this where that is smaller."""
    most_mm: float = 2.0
    """Farthest that the flow may carry a point."""
    flow: FlowConfig = field(default_factory=lambda: FlowConfig(smoothness=4.0))


@dataclass(frozen=True)
class RegisteredSkin:
    """One frame in the common texture space."""

    vertices: Float[np.ndarray, "n 3"]
    """Rig space, mm, one a vertex of the neutral; where the scan shows nothing, as the dots say."""
    seen: Bool[np.ndarray, " n"]
    albedo: Float[np.ndarray, " n"]
    """NaN where not seen."""


@dataclass(frozen=True)
class CommonSurface:
    """The neutral scan's skin on a grid of its camera's pixels: a mesh, and the texture space of all frames."""

    mesh: Mesh
    """Rig space, mm, with texture coordinates."""
    albedo: Float[np.ndarray, " n"]
    number: Int[np.ndarray, "h w"]
    """Vertex at each place of the grid; -1 for none."""
    grid_mm: float
    dots: Float[np.ndarray, "k 3"]
    """At the neutral, rig space, mm."""
    carry: Float[np.ndarray, "n k"]
    """Motion of the dots to every vertex."""
    relief: Float[np.ndarray, "h w"]
    """The neutral's displacement map, mm; NaN off the skin."""
    config: CommonConfig

    def image(self, values: Float[np.ndarray, "n *c"]) -> Float[np.ndarray, "h w *c"]:
        """Values at vertices, laid out; NaN off the skin."""
        out = np.full((*self.number.shape, *values.shape[1:]), np.nan)
        out[self.number >= 0] = values
        return out

    def register(self, scan: LightScan, view: RigView, dots: Float[np.ndarray, "k 3"]) -> RegisteredSkin:
        """Where each vertex is in another scan: with the dots, onto the scan, then by flow on displacement maps.

        Args:
            view: the camera in whose picture the scan is laid out.
            dots: in that scan, complete, rig space, mm.
        """
        by_dots = self.moved_by_dots(dots)
        skin, seen = self.onto(scan, view, by_dots)
        if self.config.refine and seen.any():
            shift = self.flow(skin, seen)
            skin = self.shifted(skin, seen, shift)
            skin, seen = self.onto(scan, view, skin, rounds=1)
        albedo = at_points(scan.albedo, view, skin)
        return RegisteredSkin(np.where(seen[:, None], skin, by_dots), seen, np.where(seen, albedo, np.nan))

    def moved_by_dots(self, dots: Float[np.ndarray, "k 3"]) -> Float[np.ndarray, "n 3"]:
        """The neutral's skin under moved dots: rigidly, then by what is left at each."""
        T_now_neutral = procrustes(self.dots, dots).transform
        left = T_now_neutral.inverse().apply(dots) - self.dots
        return T_now_neutral.apply(self.mesh.vertices + self.carry @ left)

    def onto(
        self, scan: LightScan, view: RigView, points: Float[np.ndarray, "n 3"], rounds: int = ALONG_NORMALS
    ) -> tuple[Float[np.ndarray, "n 3"], Bool[np.ndarray, " n"]]:
        """Points moved along their surface's normals to the scan, and which of them arrive."""
        normals = vertex_normals(points, self.mesh.faces)
        moved = points
        for _ in range(rounds):
            there = at_points(scan.points, view, moved)
            step = ((there - moved) * normals).sum(1, keepdims=True)
            moved = moved + np.nan_to_num(step) * normals
        off = np.linalg.norm(moved - points, axis=1)
        known = np.isfinite(at_points(scan.points[..., 2], view, moved))
        return moved, known & (off < self.config.farthest_mm)

    def flow(self, skin: Float[np.ndarray, "n 3"], seen: Bool[np.ndarray, " n"]) -> Float[np.ndarray, "h w 2"]:
        """How far on the grid each point's like lies, from the neutral's displacement map to the frame's."""
        now = displacement_map(self, skin, seen)
        both = np.isfinite(now) & np.isfinite(self.relief)
        if not both.any():
            return np.zeros((*now.shape, 2))
        scale = max(float(np.sqrt((self.relief[both] ** 2).mean())), self.config.least_relief_mm)
        found = optical_flow(self.relief / scale, now / scale, both, config=self.config.flow).flow
        most = self.config.most_mm / self.grid_mm
        length = np.linalg.norm(found, axis=-1, keepdims=True)
        return found * (most / np.maximum(length, most))

    def shifted(
        self, skin: Float[np.ndarray, "n 3"], seen: Bool[np.ndarray, " n"], shift: Float[np.ndarray, "h w 2"]
    ) -> Float[np.ndarray, "n 3"]:
        """Points of the frame's skin that lie `shift` grid steps on; a point whose new place is off the skin stays."""
        image = self.image(np.where(seen[:, None], skin, np.nan))
        y, x = np.nonzero(self.number >= 0)
        where = [y + shift[y, x, 1], x + shift[y, x, 0]]
        there = np.stack([ndimage.map_coordinates(image[..., i], where, order=1, cval=np.nan) for i in range(3)], 1)
        return np.where(np.isfinite(there).all(1, keepdims=True), there, skin)


def common_surface(
    neutral: LightScan, dots: Float[np.ndarray, "k 3"], config: CommonConfig = CommonConfig()
) -> CommonSurface:
    """Lay out the texture space on a neutral scan and its dots.

    Raises:
        BadInput: a scan that shows no surface, or fewer than three dots.
    """
    if len(dots) < 3:
        raise BadInput(
            f"neutral: {len(dots)} dots are found on it; expected 3 or more: are the dots' radius and colour told?"
        )
    step = max(round(config.grid_mm / pixel_mm(neutral)), 1)
    points, albedo = neutral.points[::step, ::step], neutral.albedo[::step, ::step]
    grid_mm = step * pixel_mm(neutral)
    faces = grid_faces(points, config.longest * grid_mm)
    if not len(faces):
        raise BadInput("neutral: the scan shows no surface")
    used = np.zeros(albedo.size, bool)
    used[faces] = True
    number = np.where(used, np.cumsum(used) - 1, -1).reshape(albedo.shape)
    height, width = albedo.shape
    y, x = np.nonzero(number >= 0)
    uv = np.stack([(x + 0.5) / width, 1 - (y + 0.5) / height], 1)
    mesh = Mesh(points[y, x], number.ravel()[faces], uv)
    carry = carried_over(points, dots, config, config.longest * grid_mm)[y, x]
    made = CommonSurface(mesh, albedo[y, x], number, grid_mm, dots, carry, np.zeros(number.shape), config)
    relief = displacement_map(made, mesh.vertices, np.ones(len(mesh.vertices), bool))
    return replace(made, relief=relief)


def carried_over(
    points: Float[np.ndarray, "h w 3"], dots: Float[np.ndarray, "k 3"], config: CommonConfig, longest_mm: float
) -> Float[np.ndarray, "h w k"]:
    """What each dot's motion does to every place of the grid: smooth, so it is found on fewer of them.

    Places without skin take after the nearest that have some.
    """
    step = max(int(np.ceil(np.sqrt(np.isfinite(points[..., 0]).sum() / config.carry_vertices))), 1)
    some = points[::step, ::step]
    faces = grid_faces(some, step * longest_mm)
    used = np.unique(faces)
    number = np.full(some[..., 0].size, -1)
    number[used] = np.arange(len(used))
    coarse = Mesh(some.reshape(-1, 3)[used], number[faces])
    carry = interpolate_from_points(coarse, closest_point(coarse, dots).attachment(), config.reach_mm)
    number = number.reshape(some.shape[:2])
    nearest = np.asarray(ndimage.distance_transform_edt(number < 0, return_distances=False, return_indices=True))
    image = carry[number[nearest[0], nearest[1]]]
    y, x = np.mgrid[: points.shape[0], : points.shape[1]] / step
    columns = [ndimage.map_coordinates(image[..., k], [y, x], order=1, mode="nearest") for k in range(len(dots))]
    return np.stack(columns, -1)


def displacement_map(
    surface: CommonSurface, skin: Float[np.ndarray, "n 3"], seen: Bool[np.ndarray, " n"]
) -> Float[np.ndarray, "h w"]:
    """Heights of a frame's skin over its own blurred self, mm, in the texture space; NaN where it is not seen.

    The scan's surface is the integral of its normals at this scale, so this is the map that the paper integrates.
    """
    image = surface.image(np.where(seen[:, None], skin, np.nan))
    known = np.isfinite(image[..., 0])
    sigma = surface.config.relief_mm / surface.grid_mm
    smooth = np.stack([masked_blur(image[..., i], known, sigma) for i in range(3)], -1)
    normals = surface.image(vertex_normals(smooth[surface.number >= 0], surface.mesh.faces))
    return np.where(known, ((image - smooth) * normals).sum(-1), np.nan)


def at_points(image: Float[np.ndarray, "h w *c"], view: RigView, points: Float[np.ndarray, "n 3"]) -> np.ndarray:
    """A picture's values where the camera sees points of rig space; NaN where one of the four pixels is."""
    pixels = view.camera.project(view.T_view_rig.apply(points))
    where = [pixels[:, 1], pixels[:, 0]]
    flat = image.reshape(*image.shape[:2], -1)
    read = [ndimage.map_coordinates(flat[..., i], where, order=1, cval=np.nan) for i in range(flat.shape[2])]
    return np.stack(read, 1).reshape(len(points), *image.shape[2:])
