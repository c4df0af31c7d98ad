"""Meshes to and from glTF's arrays: seams, vertex colours, texture, units."""

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8
from PIL import Image

from ...errors import BadInput
from ...mesh import Mesh
from .glb import Glb

MM = 1e-3
"""Metres in a millimetre."""
SKIN_LINEAR = (0.6, 0.45, 0.38)
"""Linear colour of a rig without any."""
SKIN_ROUGHNESS = 0.6
"""Of a rig's material."""


def split_seams(
    mesh: Mesh,
) -> tuple[Int[np.ndarray, "m 3"], Int[np.ndarray, " s"], Float[np.ndarray, "s 2"] | None]:
    """One texture coordinate a vertex: faces, each vertex's old one, its uv. The first n are the old ones in order."""
    n = len(mesh.vertices)
    if mesh.uv is None or mesh.uv_faces is None:
        return mesh.faces, np.arange(n), mesh.uv
    pairs = mesh.faces.astype(np.int64) * len(mesh.uv) + mesh.uv_faces
    unique, which = np.unique(pairs, return_inverse=True)
    vertex, texel = np.divmod(unique, len(mesh.uv))
    first = np.r_[True, vertex[1:] != vertex[:-1]]
    place = np.where(first, vertex, n + np.cumsum(~first) - 1)
    source = np.concatenate([np.arange(n), vertex[~first]])
    uv = np.zeros((len(source), 2))
    uv[place] = mesh.uv[texel]
    return place[which].reshape(-1, 3), source, uv


@dataclass(frozen=True)
class PrimitiveSurface:
    """Primitives as one list of glTF vertices, before those that are one point become one."""

    vertices: Float[np.ndarray, "s 3"]
    """Metres, in the scene."""
    faces: Int[np.ndarray, "m 3"]
    uv: Float[np.ndarray, "s 2"] | None
    """Origin at the lower left."""
    colors: Float[np.ndarray, "s 3"] | None
    """sRGB."""
    source: Int[np.ndarray, " s"] | None
    """The vertex of the mesh that each was, where the file says so."""
    texture: UInt8[np.ndarray, "h w 3"] | None

    def mesh(self, source: Int[np.ndarray, " s"]) -> tuple[Mesh, Int[np.ndarray, " n"]]:
        """Vertices of one `source` become one: the mesh in millimetres and the glTF vertex that each is taken from."""
        places, first = np.unique(source, return_index=True)
        if len(places) == 0 or places[-1] + 1 != len(places) or not np.isfinite(self.vertices).all():
            raise ValueError("vertices are not finite or not all there")
        seams = len(first) < len(source)
        mesh = Mesh(
            vertices=self.vertices[first] / MM,
            faces=source[self.faces],
            uv=self.uv,
            uv_faces=self.faces if seams and self.uv is not None else None,
            colors=None if self.colors is None else self.colors[first],
        )
        return mesh, first


def read_surface(glb: Glb, parts: list[dict[str, Any]], matrices: list[np.ndarray]) -> PrimitiveSurface:
    """Primitives, each with its 4x4 matrix to the scene, as one; the texture is that of the largest.

    Raises:
        BadInput: a primitive that is not made of triangles.
    """
    counts = [vertex_count(glb, part) for part in parts]
    starts = np.cumsum([0, *counts[:-1]])
    vertices, faces = [], []
    for part, matrix, start in zip(parts, matrices, starts, strict=True):
        vertices.append(glb.accessor(part["attributes"]["POSITION"]) @ matrix[:3, :3].T + matrix[:3, 3])
        turned = np.linalg.det(matrix[:3, :3]) < 0
        faces.append((_triangles(glb, part) + start)[:, :: -1 if turned else 1])
    uv = _gather(glb, parts, "TEXCOORD_0")
    colors = _gather(glb, parts, "COLOR_0")
    colors = _gather(glb, parts, "_COLOR") if colors is None else colors
    source = _gather(glb, parts, "_SOURCE") if len(parts) == 1 else None
    return PrimitiveSurface(
        vertices=np.concatenate(vertices),
        faces=np.concatenate(faces),
        uv=None if uv is None else uv * (1, -1) + (0, 1),
        colors=None if colors is None else srgb_from_linear(colors[:, :3]),
        source=None if source is None else source.astype(np.int64),
        texture=_texture(glb, parts[int(np.argmax(counts))]),
    )


def vertex_count(glb: Glb, part: dict[str, Any]) -> int:
    """How many vertices a primitive has."""
    return glb.json["accessors"][part["attributes"]["POSITION"]]["count"]


def linear_from_srgb(colors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """sRGB in 0..1 -> linear light (IEC 61966-2-1), as glTF's vertex colours want it."""
    return np.where(colors <= 0.04045, colors / 12.92, ((np.maximum(colors, 0.04045) + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(colors: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """The inverse of `linear_from_srgb`."""
    return np.where(colors <= 0.0031308, colors * 12.92, 1.055 * np.maximum(colors, 0.0031308) ** (1 / 2.4) - 0.055)


def png_bytes(image: UInt8[np.ndarray, "h w 3"]) -> bytes:
    """An image as PNG."""
    out = io.BytesIO()
    Image.fromarray(image).save(out, "PNG")
    return out.getvalue()


def _triangles(glb: Glb, part: dict[str, Any]) -> Int[np.ndarray, "m 3"]:
    if part.get("mode", 4) != 4:
        raise BadInput(f"{glb.path}: holds a mesh that is not made of triangles; export triangles")
    flat = glb.accessor(part["indices"]) if "indices" in part else np.arange(vertex_count(glb, part))
    return flat.astype(np.int64).reshape(-1, 3)


def _gather(glb: Glb, parts: list[dict[str, Any]], name: str) -> np.ndarray | None:
    if not all(name in part["attributes"] for part in parts):
        return None
    return np.concatenate([glb.accessor(part["attributes"][name]) for part in parts])


def _texture(glb: Glb, part: dict[str, Any]) -> UInt8[np.ndarray, "h w 3"] | None:
    if "material" not in part:
        return None
    surface = glb.json["materials"][part["material"]].get("pbrMetallicRoughness") or {}
    if "baseColorTexture" not in surface:
        return None
    source = glb.json["textures"][surface["baseColorTexture"]["index"]].get("source")
    image = {} if source is None else glb.json["images"][source]
    if "bufferView" not in image:
        return None
    start, length, _ = glb.view(image["bufferView"])
    return np.asarray(Image.open(io.BytesIO(glb.blob[start : start + length])).convert("RGB"))
