"""A face as an image: positions and colour on the cylinder round the head (Casas et al. 2016, sec. 3 and 4.1)."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import distance_transform_edt

from ..errors import BadInput
from ..image_space.layout import sampled
from ..io.gltf.mesh import split_seams
from ..mesh import Cylinder, Mesh, Scan, SurfaceImage, face_normals, grid_faces
from ..mesh.scan_color import vertex_colours
from ..one_line import one_line

CYLINDER = Cylinder(x=0.0, z=0.0, radius=90.0)
"""The axis goes through face space's origin, the middle of the head, so that both ears are on it."""
HALF_ARC_MM = 165.0
"""The map's half width: 105 degrees, from ear to ear."""
TOP_MM, BOTTOM_MM = 110.0, -150.0
"""The map's upper and lower end in face space: past the hair line and under the chin."""
JUMP_MM = 4.0
"""Neighbouring pixels whose points are farther apart than this, a mm of pixel more, are not one surface."""
FACING = 0.05
"""Triangles that face away from the axis by less than this cosine are seen from inside, or not at all."""


@dataclass(frozen=True)
class CylinderLayout:
    """Where pixels of a map are: the subject's left is on the right, up is up. All maps of one pixel size share it."""

    pixel_mm: float = 0.5
    """Side of a pixel on the cylinder of radius 90 mm, mm."""

    def __post_init__(self):
        if not 0.1 <= self.pixel_mm <= 8:
            raise BadInput(f"map: pixels of {self.pixel_mm} mm; give 0.1 to 8")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width."""
        height, width = TOP_MM - BOTTOM_MM, 2 * HALF_ARC_MM
        return 1 + round(height / self.pixel_mm), 1 + round(width / self.pixel_mm)

    def pixels(self, points: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 2"]:
        """Face space (mm) -> (x, y) in the image, centres at integers, y down; also beyond its border."""
        flat = CYLINDER.unroll(points.reshape(-1, 3))
        places = np.stack([flat[:, 0] + HALF_ARC_MM, TOP_MM - flat[:, 1]], 1) / self.pixel_mm
        return places.reshape(*points.shape[:-1], 2)

    def points(self, radii: Float[np.ndarray, "h w"]) -> Float[np.ndarray, "h w 3"]:
        """Points at these distances from the axis, mm, one a pixel; NaN stays."""
        rows, columns = (np.arange(n) * self.pixel_mm for n in self.shape)
        angle = (columns - HALF_ARC_MM) / CYLINDER.radius
        x, z = radii * np.sin(angle), radii * np.cos(angle)
        return np.stack([x + CYLINDER.x, np.where(np.isnan(radii), np.nan, TOP_MM - rows[:, None]), z + CYLINDER.z], -1)

    @staticmethod
    def of_shape(height: int, width: int) -> "CylinderLayout":
        """The layout that has images of this size.

        Raises:
            BadInput: none has.
        """
        found = CylinderLayout(2 * HALF_ARC_MM / max(width - 1, 1)) if width > 40 else None
        if found is None or found.shape != (height, width):
            raise BadInput(f"a map of {width} x {height} pixels is none of ours; `mien scan` writes them")
        return found


@dataclass(frozen=True)
class CylinderMap:
    """A face laid out: one point, colour and confidence a pixel."""

    layout: CylinderLayout
    positions: Float32[np.ndarray, "h w 3"]
    """Face space, mm; NaN where there is no surface."""
    colors: Float32[np.ndarray, "h w 3"]
    """sRGB in 0..1; NaN where there is no surface."""
    confidence: Float32[np.ndarray, "h w"]
    """0..1: how sure the point is; 0 where there is none."""
    name: str = ""

    def __repr__(self) -> str:
        h, w = self.layout.shape
        return one_line(self, self.name, f"{w} x {h} pixels", f"{self.known.mean():.0%} known")

    @cached_property
    def known(self) -> Bool[np.ndarray, "h w"]:
        """Pixels that have a point."""
        return np.isfinite(self.positions[..., 0])

    def at(self, pixels: Float[np.ndarray, "*p 2"]) -> tuple[np.ndarray, np.ndarray]:
        """Positions and colours between pixels (x, y); NaN beside holes and outside."""
        both = np.concatenate([self.positions, self.colors], -1)
        values = sampled(both, pixels)
        h, w = self.layout.shape
        outside = (pixels < -0.5).any(-1) | (pixels[..., 0] > w - 0.5) | (pixels[..., 1] > h - 0.5)
        values[outside] = np.nan
        return values[..., :3], values[..., 3:]

    def named(self, name: str) -> "CylinderMap":
        """The same under another name."""
        return replace(self, name=name)


def map_of_scan(scan: Scan, layout: CylinderLayout) -> CylinderMap:
    """A mesh in face space (mm) laid out: of surfaces one behind the other, the outermost (sec. 4.1).

    Raises:
        BadInput: nothing of the mesh lies before the cylinder's axis.
    """
    mesh = with_corner_uv(scan.mesh)
    scan = replace(scan, mesh=mesh)
    places, faces = outermost_first(mesh, layout)
    if not len(faces):
        raise BadInput(f"{scan.name or 'scan'}: nothing of it lies round the face; is it a face?")
    image = SurfaceImage(places, faces, layout.shape)
    facing = _facing(mesh.vertices, faces)
    confidence = np.where(image.mask, facing[image.faces], 0.0)
    positions = image.draw(mesh.vertices)
    colors = _colours_of(scan, image)
    return CylinderMap(layout, _single(positions), _single(colors), _single(confidence), scan.name)


def outermost_first(mesh: Mesh, layout: CylinderLayout) -> tuple[np.ndarray, np.ndarray]:
    """Vertices in the map's pixels, and the triangles that face out, those farthest from the axis first."""
    places = layout.pixels(mesh.vertices)
    corners = places[mesh.faces]
    across = np.ptp(corners[..., 0], axis=1) * layout.pixel_mm
    whole = across < np.pi / 2 * CYLINDER.radius
    out = _facing(mesh.vertices, mesh.faces) > FACING
    faces = mesh.faces[whole & out]
    radius = np.hypot(mesh.vertices[:, 0] - CYLINDER.x, mesh.vertices[:, 2] - CYLINDER.z)
    order = np.argsort(-radius[faces].mean(1), kind="stable")
    return places, faces[order]


def mesh_of_map(map_: CylinderMap, step: int = 1) -> Scan:
    """The map's surface: neighbouring pixels triangulated (sec. 3), with its colours as texture.

    step: every so many pixels.
    """
    positions = map_.positions[::step, ::step].astype(np.float64)
    faces = grid_faces(positions, JUMP_MM + step * map_.layout.pixel_mm)
    points = positions.reshape(-1, 3)
    used, again = np.unique(faces, return_inverse=True)
    full_h, full_w = map_.layout.shape
    row, column = np.divmod(used, positions.shape[1])
    uv = np.stack([(column * step + 0.5) / full_w, 1 - (row * step + 0.5) / full_h], 1)
    texture = (np.nan_to_num(filled(map_.colors)) * 255).round().astype(np.uint8)
    return Scan(Mesh(points[used], again.reshape(-1, 3), uv), texture, map_.name)


def filled(image: Float[np.ndarray, "h w c"]) -> Float[np.ndarray, "h w c"]:
    """The image with its NaN pixels set to the nearest pixel's value."""
    gone = np.isnan(image[..., 0])
    if not gone.any() or gone.all():
        return image
    rows, columns = np.asarray(distance_transform_edt(gone, return_distances=False, return_indices=True))
    return image[rows, columns]


def _facing(vertices: np.ndarray, faces: np.ndarray) -> Float[np.ndarray, " m"]:
    """Cosine between each triangle's normal and the way out from the axis."""
    middle = vertices[faces].mean(1) - np.array([CYLINDER.x, 0.0, CYLINDER.z])
    middle[:, 1] = 0.0
    middle /= np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-9)
    return (face_normals(vertices, faces) * middle).sum(1)


def with_corner_uv(mesh: Mesh) -> Mesh:
    """The same surface with one texture coordinate a vertex: vertices on seams are doubled."""
    if mesh.uv is None or mesh.uv_faces is None:
        return mesh
    faces, source, uv = split_seams(mesh)
    colors = None if mesh.colors is None else mesh.colors[source]
    return Mesh(mesh.vertices[source], faces, uv, colors=colors)


def _colours_of(scan: Scan, image: SurfaceImage) -> Float[np.ndarray, "h w 3"]:
    """sRGB under each pixel; mid grey where the scan has no colour."""
    mesh = scan.mesh
    if scan.texture is not None and mesh.uv is not None:
        return texture_at(scan.texture, image.draw(mesh.uv))
    colours = vertex_colours(scan)
    if colours is None:
        colours = np.full((len(mesh.vertices), 3), 0.5)
    return image.draw(colours)


def texture_at(texture: np.ndarray, uv: Float[np.ndarray, "*p 2"]) -> Float[np.ndarray, "*p 3"]:
    """Bilinear colours in 0..1 at uv (origin at the lower left); NaN stays."""
    height, width = texture.shape[:2]
    places = np.stack([uv[..., 0] * width - 0.5, (1 - uv[..., 1]) * height - 0.5], -1)
    return sampled(texture.astype(np.float32) / 255, np.nan_to_num(places)) + 0 * uv[..., :1]


def _single(image: np.ndarray) -> np.ndarray:
    return image.astype(np.float32)
