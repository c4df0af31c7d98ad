"""Figures 1 and 3 to 10 of Casas et al. 2016 redrawn on the stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image

from ..blendshapes.build.masks import TexturedRig, texture_weights
from ..blendshapes.build.texture import as_bytes, expression_texture
from ..blendshapes.correspond.landmarks import MapLandmarks
from ..blendshapes.cylinder_map import CylinderMap
from ..blendshapes.expression import BuiltShape, NeutralFace
from ..faces.bundled import load_face
from ..pictures import Renderer, contact_sheet, frontal_camera
from ..pictures.render import Look
from ..pictures.show import rig_look
from ..pictures.view import View
from ..rig import Performance, Rig
from .blendshapes_ways import Points, warp_of

PIXELS = 280
"""Side of a face in a figure."""
RAYS = 12
"""For ambient occlusion: few, a demo is to be over soon."""
HEAD_SHARE = 0.5
"""Of a driver's picture, across its shorter side."""
CHECKS = 48
"""Fields a side of the checked texture that shows where skin goes."""
DOT = 1
"""Half the side of a landmark's dot, pixels."""
BROW_MM, FACE_MM = ((-62.0, 62.0), (4.0, 62.0)), ((-95.0, 95.0), (-100.0, 100.0))
"""What of the face figures show: across and up, face space."""

Picture = UInt8[np.ndarray, "h w 3"]
Sized = UInt8[np.ndarray, "rows columns 3"]
"""A picture of another size than the one it is made of."""


def face_look(rig: Rig) -> Look:
    """How the rig is drawn."""
    return replace(rig_look(rig.neutral), occlusion=RAYS)


def posed(textured: TexturedRig, weights: Mapping[str, float]) -> tuple[Points, Picture]:
    """Vertices and texture of the rig under some weights, by name."""
    values = np.array([weights.get(name, 0.0) for name in textured.rig.names])
    shares = texture_weights(values[None], textured.mixes)[0]
    return textured.rig.vertices(values), textured.texture(shares)


def posed_sheet(textured: TexturedRig, poses: Mapping[str, Mapping[str, float]], columns: int | None = None) -> Picture:
    """The textured rig in several poses, each with its name."""
    view = frontal_camera(textured.rig.neutral, PIXELS, frame=front_of(textured.rig))
    renderer = Renderer(textured.rig.neutral, face_look(textured.rig), textured.rig.texture)
    cells = [posed_picture(textured, weights, renderer, view) for weights in poses.values()]
    return contact_sheet(cells, list(poses), columns)


def posed_picture(textured: TexturedRig, weights: Mapping[str, float], renderer: Renderer, view: View) -> Picture:
    """The textured rig in one pose; `renderer` is of its mesh."""
    vertices, texture = posed(textured, weights)
    return renderer.with_texture(texture).draw(*view, vertices=vertices)


def front_of(rig: Rig) -> Points:
    """The face's part of a rig of the bundled topology, to be framed."""
    return rig.neutral.vertices[load_face().regions["face"] > 0.5]


def tracking_sheet(rig: Rig, names: Sequence[str]) -> Picture:
    """Figure 6: a checked texture on every shape; where it is stretched, skin is."""
    row, column = np.mgrid[:1024, :1024] * CHECKS // 1024
    fields = np.where((row + column) % 2, 225, 95).astype(np.uint8)
    checked = np.stack([fields, fields, np.full_like(fields, 150)], -1)
    view = frontal_camera(rig.neutral, PIXELS, frame=front_of(rig))
    renderer = Renderer(rig.neutral, face_look(rig), checked)
    shapes = [rig.neutral.vertices, *(rig.neutral.vertices + rig.deltas[rig.index(name)] for name in names)]
    return contact_sheet([renderer.draw(*view, vertices=v) for v in shapes], ["neutral", *names], 4)


def shape_sheet(rig: Rig, names: Sequence[str]) -> Picture:
    """Figure 9: shapes without texture."""
    plain = replace(rig.neutral, colors=None, uv=None, uv_faces=None)
    view = frontal_camera(rig.neutral, PIXELS, frame=front_of(rig))
    renderer = Renderer(plain, face_look(rig))
    shapes = [rig.neutral.vertices, *(rig.neutral.vertices + rig.deltas[rig.index(name)] for name in names)]
    return contact_sheet([renderer.draw(*view, vertices=v) for v in shapes], ["neutral", *names], 4)


def landmark_sheet(maps: Mapping[str, tuple[CylinderMap, MapLandmarks]]) -> Picture:
    """Figure 3: landmarks on the maps."""
    cells = []
    for map_, landmarks in maps.values():
        picture = as_bytes(map_.colors)
        for x, y in np.round(landmarks.pixels(map_.layout)[landmarks.known]).astype(int):
            picture[max(y - DOT, 0) : y + DOT + 1, max(x - DOT, 0) : x + DOT + 1] = (60, 230, 90)
        cells.append(cut(picture, map_, FACE_MM))
    return contact_sheet(cells, list(maps), len(maps))


def warp_sheet(neutral: NeutralFace, shapes: Sequence[BuiltShape]) -> Picture:
    """Figure 4: the target, each source, and the source warped to the target."""
    cells, captions = [], []
    for shape in shapes:
        _, warped = shape.map.at(shape.warp.pixels)
        for name, colors in (("neutral", neutral.map.colors), (shape.name, shape.map.colors), ("warped", warped)):
            cells.append(cut(as_bytes(colors), neutral.map, FACE_MM))
            captions.append(name)
    return contact_sheet(cells, captions, 3)


def drift_sheet(neutral: NeutralFace, shape: BuiltShape, aligned, template: Points) -> Picture:
    """Figure 1: the brows of the neutral's texture and of an expression's, ours and by the template."""
    slid = warp_of(template, aligned, neutral)
    theirs, _ = expression_texture(neutral.grid, aligned.map, slid, neutral.texture)
    where = brow_texels(neutral)
    both = {"neutral": neutral.texture, f"{shape.name}, ours": shape.texture, f"{shape.name}, template": theirs}
    cells = [resized(as_bytes(texture[where]), 2 * PIXELS) for texture in both.values()]
    return contact_sheet(cells, list(both), 1)


def brow_texels(neutral: NeutralFace) -> tuple[slice, slice]:
    """Rows and columns of the texture that hold the brows."""
    mesh = neutral.artist.mesh
    assert mesh.uv is not None
    (left, right), (low, high) = BROW_MM
    x, y, z = mesh.vertices.T
    inside = (x > left) & (x < right) & (y > low) & (y < high) & (z > 0) & neutral.artist.shown
    corners = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
    used = corners[inside[mesh.faces].all(1)].ravel()
    size = neutral.texture.shape[0]
    u, v = mesh.uv[used, 0] * size, (1 - mesh.uv[used, 1]) * size
    return slice(int(v.min()), int(v.max()) + 1), slice(int(u.min()), int(u.max()) + 1)


def cut(picture: Picture, map_: CylinderMap, box) -> Sized:
    """The part of a map's picture that lies before the face, as large as a figure's cells."""
    (left, right), (low, high) = box
    corners = np.array([[left, high, 90.0], [right, low, 90.0]])
    (x0, y0), (x1, y1) = np.round(map_.layout.pixels(corners)).astype(int)
    return resized(picture[max(y0, 0) : y1, max(x0, 0) : x1], PIXELS)


def resized(picture: Picture, width: int) -> Sized:
    """The picture at another width."""
    height = max(1, round(width * picture.shape[0] / picture.shape[1]))
    return np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.LANCZOS))


@dataclass(frozen=True)
class Driven:
    """A clip before the sensor, and the rig that it plays."""

    pictures: Sequence[Picture]
    performance: Performance
    head_share: float = HEAD_SHARE
    """Of a picture's shorter side: what the head takes."""


def puppet_sheet(clip: Driven, textured: TexturedRig, numbers: Sequence[int]) -> Picture:
    """Figures 7, 8 and 10: the driver's pictures over the driven face, at the same moments."""
    performance = clip.performance
    above = [resized(middle(clip.pictures[i], clip.head_share), PIXELS) for i in numbers]
    view = frontal_camera(textured.rig.neutral, PIXELS, frame=front_of(textured.rig))
    renderer = Renderer(textured.rig.neutral, face_look(textured.rig), textured.rig.texture)
    below = []
    for i in numbers:
        weights = played_weights(performance, textured.rig, i)
        shares = texture_weights(weights[None], textured.mixes)[0]
        vertices = performance.rig.vertices(performance.weights[i])
        below.append(renderer.with_texture(textured.texture(shares)).draw(*view, vertices=vertices))
    return contact_sheet([*above, *below], None, len(numbers))


def middle(picture: Picture, head_share: float = HEAD_SHARE) -> Sized:
    """The square in the middle of a driver's picture, where the head is."""
    height, width = picture.shape[:2]
    side = round(head_share * min(height, width))
    top, left = (height - side) // 2, (width - side) // 2
    return np.ascontiguousarray(picture[top : top + side, left : left + side])


def played_weights(performance: Performance, rig: Rig, frame: int) -> Float[np.ndarray, " shapes"]:
    """One frame's weights in the order of a rig's shapes; correctives have no texture."""
    played = dict(zip(performance.rig.names, performance.weights[frame], strict=True))
    return np.array([played.get(name, 0.0) for name in rig.names])
