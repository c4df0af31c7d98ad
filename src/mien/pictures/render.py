"""Pictures of faces: shaded, textured or as heat maps. No display, no GPU, no noise."""

from copy import copy
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int, UInt8

from .._kernels.shade import bilinear, interpolate, lift, light, resolve
from .._kernels.zbuffer import pixel_weights, zbuffer
from ..camera import Camera
from ..errors import BadInput
from ..mesh import Mesh, loop_refinement, vertex_normals
from ..transforms import Transform
from .color import LEVEL_OF_ROOT, LINEAR_OF_BYTE, to_bytes, to_linear
from .colormap import colors_of, own_limits
from .eyes import eyeballs
from .occlusion import ambient_occlusion
from .shadow import shadow_map


@dataclass(frozen=True)
class Lamp:
    """A far lamp that moves with the camera."""

    direction: tuple[float, float, float]
    """Towards the lamp, camera space (x right, y down, z forward); of any length."""
    color: tuple[float, float, float]
    """Linear light; 1 makes a white surface that faces the lamp white."""
    gloss: float = 1.0
    """Share of it that mirrors off the surface."""


@dataclass(frozen=True)
class Look:
    """How a picture is lit and drawn. Lamps stand still relative to the camera."""

    supersample: int = 2
    """Samples a side in every pixel; 1 switches antialiasing off."""
    refine: int = 0
    """Rounds of smooth subdivision before drawing: 1 or 2 give a coarse rig round outlines; 0 for scans."""
    skin: tuple[float, float, float] = (0.80, 0.66, 0.58)
    """Colour of a mesh that has none, sRGB."""
    key: Lamp = Lamp((-0.55, -0.62, -0.72), (1.02, 0.95, 0.86))
    """The main lamp, the one that casts shadows."""
    others: tuple[Lamp, ...] = (
        Lamp((0.85, -0.10, -0.55), (0.20, 0.24, 0.30)),
        Lamp((0.80, -0.45, 0.70), (0.42, 0.46, 0.52), 0.3),
        Lamp((-0.85, -0.35, 0.75), (0.26, 0.26, 0.28), 0.3),
    )
    """A cool fill and two rim lamps behind the head."""
    sky: tuple[float, float, float] = (0.30, 0.32, 0.35)
    """Ambient light from above, linear."""
    ground: tuple[float, float, float] = (0.15, 0.13, 0.12)
    """Ambient light from below, linear."""
    wrap: tuple[float, float, float] = (0.28, 0.14, 0.09)
    """How far light bleeds round the terminator, by colour, as a share of a right angle's sine; 0 = hard."""
    reflectance: float = 0.028
    """Of the surface's gloss at normal incidence; 0 = matt."""
    roughness: float = 0.48
    """Width of the gloss, 0..1."""
    occlusion: int = 64
    """Fixed rays over the sphere for ambient occlusion, a vertex; 0 switches it off."""
    softness: float = 1.5
    """Half the width of the key's shadow edges, mm; 0 switches shadows off."""
    background: tuple[tuple[float, float, float], ...] = ((0.36, 0.37, 0.39), (0.15, 0.155, 0.165))
    """The middle and the corners of the background, sRGB."""
    alpha: bool = False
    """Leave the background out: RGBA, straight alpha."""
    colormap: str = "heat"
    """Which map turns values into colours (`mien.pictures.colormap`)."""
    limits: tuple[float, float] | None = None
    """Values at the two ends of the colour map; their own range where None."""
    value_shading: float = 0.5
    """How much light and shade show through a heat map, 0..1; 0 = the map's colours exactly."""


def render(
    mesh: Mesh,
    camera: Camera,
    T_camera_face: Transform,
    look: Look = Look(),
    *,
    texture: UInt8[np.ndarray, "th tw 3"] | None = None,
    values: Float[np.ndarray, " n"] | None = None,
) -> UInt8[np.ndarray, "h w c"]:
    """A picture of a mesh, RGB (RGBA with `look.alpha`); one-shot `Renderer(mesh, look, texture).draw(...)`.

    Colour comes from `values` (a heat map), else `texture` (for the mesh's uv), else vertex colours, else `look.skin`.

    Args:
        mesh: face space, mm.
        values: one a vertex, drawn through `look.colormap`; grey where NaN.
    """
    return Renderer(mesh, look, texture).draw(camera, T_camera_face, values=values)


class Renderer:
    """A surface made ready for pictures: draw it often, from anywhere, in other shapes of the same topology."""

    def __init__(self, mesh: Mesh, look: Look = Look(), texture: UInt8[np.ndarray, "th tw 3"] | None = None):
        self.mesh, self.look, self.texture = mesh, look, texture
        self._uv = None if texture is None else _corner_uv(mesh)
        self._faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)
        self._matrix = self._between = sp.csr_matrix(sp.identity(len(mesh.vertices)))
        for _ in range(look.refine):
            finer = loop_refinement(self._faces, self._matrix.get_shape()[0])
            self._faces, self._matrix = finer.faces, sp.csr_matrix(finer.matrix @ self._matrix)
            self._between = sp.csr_matrix(finer.between @ self._between)
            self._uv = None if self._uv is None else finer.corners(self._uv)
        self._eyes = eyeballs(mesh)
        self._carried = self._painted(mesh.colors)

    def with_texture(self, texture: UInt8[np.ndarray, "th tw 3"]) -> "Renderer":
        """The same surface with another picture on it."""
        other = copy(self)
        other.texture = texture
        return other

    def with_colors(self, colors: Float[np.ndarray, "n 3"] | None) -> "Renderer":
        """The same surface with other vertex colours, sRGB."""
        other = copy(self)
        other._carried = self._painted(colors)
        return other

    def _painted(self, colors: Float[np.ndarray, "n 3"] | None) -> np.ndarray:
        """Albedo and eyes of every vertex that is drawn."""
        color = np.tile(self.look.skin, (len(self.mesh.vertices), 1)) if colors is None else colors
        albedo = to_linear(np.asarray(color, dtype=np.float64))
        return self._between @ np.column_stack([albedo, self._eyes])

    def draw(
        self,
        camera: Camera,
        T_camera_face: Transform,
        *,
        vertices: Float[np.ndarray, "n 3"] | None = None,
        values: Float[np.ndarray, " n"] | None = None,
        open_sky: Float[np.ndarray, " n"] | None = None,
    ) -> UInt8[np.ndarray, "h w c"]:
        """A picture, RGB (RGBA with `look.alpha`).

        Args:
            vertices: another shape of the mesh, mm.
            values: one a vertex, drawn as a heat map.
            open_sky: ambient occlusion known already (`ambient_occlusion`), say the neutral face's for a whole film.
        """
        mesh = self.mesh if vertices is None else self.mesh.with_vertices(vertices)
        surface = Mesh(self._matrix @ mesh.vertices, self._faces)
        if open_sky is None:
            rays = self.look.occlusion
            open_sky = ambient_occlusion(mesh, rays) if rays else np.ones(len(mesh.vertices))
        normals = T_camera_face.rotate(vertex_normals(surface.vertices, surface.faces))
        samples = self._samples(surface, camera.scaled(self.look.supersample), T_camera_face)
        return _resolved(self._lit(samples, normals, self._between @ open_sky, values), samples, camera, self.look)

    def _samples(self, surface: Mesh, camera: Camera, T_camera_face: Transform) -> "_Samples":
        points = T_camera_face.apply(surface.vertices)
        intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
        image, _ = zbuffer(points, self._faces, intrinsics, camera.height, camera.width)
        pixels = np.flatnonzero(image.reshape(-1) >= 0)
        faces = image.reshape(-1)[pixels]
        weights = pixel_weights(points, self._faces, intrinsics, image, pixels)
        behind = _seen_from_behind(points, self._faces)[faces]
        return _Samples(points, pixels, faces, self._faces[faces], weights, behind)

    def _lit(self, samples: "_Samples", normals, clear, values) -> Float[np.ndarray, "s 3"]:
        """Linear light of each sample."""
        look = self.look
        normal, point, rest = (
            interpolate(carried, samples.corners, samples.weights)
            for carried in (normals, samples.points, np.column_stack([clear, self._carried]))
        )
        clear, albedo, wet = rest[:, 0], rest[:, 1:4], rest[:, 4]
        normal[samples.behind] *= -1
        if 2 * samples.behind.sum() < len(normal):
            clear[samples.behind] *= 0.35
        scene = _Scene(normal, point, clear, self._arrives(samples, normals, normal), look)
        if values is not None:
            return self._heat(samples, self._between @ values, scene)
        if self.texture is not None and self._uv is not None:
            corners = 3 * samples.faces[:, None].astype(np.int64) + np.arange(3)
            uv = interpolate(self._uv.reshape(-1, 2), corners, samples.weights)
            albedo = bilinear(self.texture, LINEAR_OF_BYTE, uv)
        return scene.light(albedo, wet, [*look.wrap, look.reflectance, look.roughness])

    def _arrives(self, samples: "_Samples", normals, normal) -> Float[np.ndarray, " s"]:
        """The share of the key lamp that reaches each sample."""
        if not self.look.softness or not len(normal):
            return np.ones(len(normal), np.float32)
        lamp = np.array(_unit(self.look.key.direction))
        seen = shadow_map(samples.points, self._faces, lamp, self.look.softness)
        return seen.arrives(lift(samples.points, normals, samples.corners, samples.weights), normal)

    def _heat(self, samples: "_Samples", values, scene: "_Scene") -> Float[np.ndarray, "s 3"]:
        """The colour map's colours, with some light and shade over them."""
        look = self.look
        value = np.einsum("sc,sc->s", values[samples.corners], samples.weights)
        colors = colors_of(value, look.limits or own_limits(values), look.colormap, linear=True)
        white = np.full((len(value), 3), 0.8, np.float32)
        lit = scene.light(white, np.zeros(len(value), np.float32), [0.1, 0.1, 0.1, 0.0, 1.0])
        shade = 1 - look.value_shading * (1 - np.minimum(lit.mean(1, keepdims=True) / 0.6, 1))
        return (colors * shade).astype(np.float32)


@dataclass(frozen=True)
class _Scene:
    """Everything about the samples but their colour."""

    normal: Float[np.ndarray, "s 3"]
    point: Float[np.ndarray, "s 3"]
    clear: Float[np.ndarray, " s"]
    arrives: Float[np.ndarray, " s"]
    look: Look

    def light(self, albedo, wet, skin: list[float]) -> Float[np.ndarray, "s 3"]:
        """Linear light towards the camera."""
        look = self.look
        lamps = np.array([[*_unit(lamp.direction), *lamp.color, lamp.gloss] for lamp in (look.key, *look.others)])
        ambient = np.array([look.sky, look.ground])
        return light(self.normal, self.point, albedo, self.clear, self.arrives, wet, lamps, ambient, np.array(skin))


@dataclass(frozen=True)
class _Samples:
    """The samples of a picture that fall on the mesh."""

    points: Float[np.ndarray, "n 3"]
    """Vertices in camera space."""
    pixels: Int[np.ndarray, " s"]
    """Flat index in the supersampled picture."""
    faces: Int[np.ndarray, " s"]
    corners: Int[np.ndarray, "s 3"]
    weights: Float[np.ndarray, "s 3"]
    behind: np.ndarray
    """Whether the triangle shows its inner side."""


def _corner_uv(mesh: Mesh) -> Float[np.ndarray, "m 3 2"]:
    if mesh.uv is None:
        raise BadInput("a texture, but a mesh with no texture coordinates: give one with `uv`, or no texture")
    return mesh.uv[mesh.uv_faces if mesh.uv_faces is not None else mesh.faces]


def _seen_from_behind(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Which triangles (camera space) turn their inner side to the camera."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.einsum("md,md->m", a, np.cross(b - a, c - a)) > 0


def _resolved(lit: np.ndarray, samples: _Samples, camera: Camera, look: Look) -> UInt8[np.ndarray, "h w c"]:
    """Samples -> pixels over the background."""
    backdrop = _backdrop(camera.width, camera.height, look.background)
    over, covered, alone = resolve(lit, samples.pixels, backdrop, LEVEL_OF_ROOT, look.supersample)
    return np.concatenate([alone, to_bytes(covered)[..., None]], 2) if look.alpha else over


@lru_cache(maxsize=8)
def _backdrop(width: int, height: int, background: tuple) -> Float[np.ndarray, "h w 3"]:
    """A soft round glow, linear light; ordered dither keeps its steps from showing as rings."""
    x, y = np.linspace(-1, 1, width), np.linspace(-1, 1, height)[:, None]
    out = np.clip((x * x + y * y) / 2, 0, 1)[..., None] ** 0.75
    middle, corners = np.array(background)
    bayer = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]]) / 16 - 15 / 32
    dither = np.tile(bayer, (height // 4 + 1, width // 4 + 1))[:height, :width, None] / 255
    return to_linear(np.clip((1 - out) * middle + out * corners + dither, 0, 1)).astype(np.float32)


def _unit(direction: tuple[float, float, float]) -> np.ndarray:
    return np.array(direction) / np.linalg.norm(direction)
