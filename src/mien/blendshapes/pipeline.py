"""Captures to a rig whose textures blend with its shapes (Casas et al. 2016, fig. 2)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..faces.arkit import ARKIT_NAMES
from ..faces.bundled import BundledFace
from ..mesh import mass
from ..one_line import one_line
from ..progress import SILENT, Progress
from ..rig import Rig
from .align import AlignConfig, align, stabilised
from .build.arkit import CompleteConfig, complete_arkit, transferred
from .build.artist_mesh import ArtistMesh, bundled_mesh, complete, look_up
from .build.masks import TexturedRig, mask_textures, masked, region_masks, regions_of
from .build.texture import TexelGrid, as_bytes, expression_texture, neutral_texture, texel_grid
from .captures import Capture
from .correspond.dense import Warp, WarpConfig, warp
from .correspond.landmarks import MapLandmarks, along_contours, landmarks_on_map
from .correspond.model_motion import mix_of, motion_image
from .cylinder_map import CylinderMap


@dataclass(frozen=True)
class RigConfig:
    """How captures become a rig."""

    texture: int = 1024
    """Texels a side."""
    model: bool = True
    """The bundled expressions' motion starts the warp where no landmark is; off: the paper's triangles alone."""
    stabilise: bool = True
    """The head is held still by all skin that does not move; off: by the forehead alone, as in the paper."""
    masks: bool = True
    """Expressions are kept to the regions that they move."""
    align: AlignConfig = field(default_factory=AlignConfig)
    warp: WarpConfig = field(default_factory=WarpConfig)
    complete: CompleteConfig = field(default_factory=CompleteConfig)


@dataclass(frozen=True)
class NeutralFace:
    """The person at rest: what every expression is brought to."""

    map: CylinderMap
    landmarks: MapLandmarks
    artist: ArtistMesh
    units: Float[np.ndarray, "52 n 3"]
    """The bundled expressions on this face."""
    grid: TexelGrid
    texture: Float[np.ndarray, "h w 3"]


@dataclass(frozen=True)
class BuiltShape:
    """One expression on the artist mesh."""

    name: str
    delta: Float[np.ndarray, "n 3"]
    """Mm, whole."""
    texture: Float[np.ndarray, "h w 3"]
    seen: Bool[np.ndarray, " n"]
    """Vertices that the capture shows."""
    map: CylinderMap
    """The capture in the neutral's frame."""
    warp: Warp
    landmarks: int
    """How many are known in both."""
    rms_mm: float
    """Of the forehead after ICP, mm."""


@dataclass(frozen=True)
class BuiltRig:
    """A person's rig and how it came about."""

    textured: TexturedRig
    neutral: NeutralFace
    shapes: tuple[BuiltShape, ...]
    left_out: tuple[str, ...] = ()
    """Captures that could not be used, a line each."""

    def __repr__(self) -> str:
        return one_line(self, self.textured)


def build_rig(
    captures: Sequence[Capture],
    neutral: str,
    face: BundledFace,
    arkit: bool = False,
    config: RigConfig = RigConfig(),
    progress: Progress = SILENT,
) -> BuiltRig:
    """The neutral on the artist mesh, then every expression on it, then masks; `arkit` completes the 52.

    Raises:
        BadInput: the neutral cannot be used, or no capture bears its name. Another that cannot be used is left out.
    """
    named = {capture.name: capture.map for capture in captures}
    progress.update("the neutral face", 0, 1)
    calm = neutral_face(named.pop(neutral), face, config)
    progress.update("the neutral face", 1, 1)
    shapes, left_out = [], []
    for done, map_ in enumerate(named.values()):
        progress.update("expressions", done, len(named))
        try:
            shapes.append(build_shape(map_, calm, face, config))
        except BadInput as error:
            left_out.append(f"left out: {error}")
    progress.update("expressions", len(named), len(named))
    textured = with_masks(calm, shapes, face, config)
    if arkit:
        textured = completed(textured, calm, shapes, face, config)
    return BuiltRig(textured, calm, tuple(shapes), tuple(left_out))


def neutral_face(map_: CylinderMap, face: BundledFace, config: RigConfig) -> NeutralFace:
    """Landmarks, artist mesh and base texture of the neutral (sec. 4.2 and 5.1)."""
    landmarks = landmarks_on_map(map_)
    artist = bundled_mesh(map_, landmarks, face)
    units = transferred(face, artist.mesh)
    grid = texel_grid(artist.mesh, artist.shown, map_, config.texture)
    return NeutralFace(map_, landmarks, artist, units, grid, neutral_texture(grid, map_))


def build_shape(map_: CylinderMap, neutral: NeutralFace, face: BundledFace, config: RigConfig) -> BuiltShape:
    """One capture: aligned by the forehead, warped to the neutral, looked up on the artist mesh (sec. 3 to 5.1).

    Raises:
        BadInput: no face, no forehead, or too few landmarks.
    """
    aligned = align(map_, landmarks_on_map(map_), neutral.map, neutral.landmarks, config.align)
    artist, expected = neutral.artist, None
    if config.model:
        mix = mix_of(neutral.units, artist.mesh, aligned.landmarks, neutral.landmarks)
        expected = motion_image(artist.mesh, np.tensordot(mix, neutral.units, axes=1), neutral.map.layout)
    warped = warp(aligned.map, aligned.landmarks, neutral.map, neutral.landmarks, expected=expected, config=config.warp)
    found = look_up(artist, aligned.map, warped)
    marks = aligned.landmarks
    if config.stabilise:
        share = mass(artist.mesh.vertices, artist.mesh.faces) * face.regions["face"]
        still = stabilised(found, artist.mesh.vertices, share)
        found, marks = still.apply(found), marks.moved(still)
    seen = np.isfinite(found[:, 0])
    if not seen.any():
        raise BadInput(f"{map_.name}: shows nothing of the face that the neutral shows")
    edges = along_contours(artist.mesh.vertices, face.contours, marks, neutral.landmarks)
    delta, _ = complete(artist, found, face, neutral.units, edges)
    texture, _ = expression_texture(neutral.grid, aligned.map, warped, neutral.texture)
    known = int((aligned.landmarks.known & neutral.landmarks.known).sum())
    return BuiltShape(map_.name, delta, texture, seen, aligned.map, warped, known, aligned.rms_mm)


def with_masks(neutral: NeutralFace, shapes: Sequence[BuiltShape], face: BundledFace, config: RigConfig) -> TexturedRig:
    """Delta shapes and textures with their masks (sec. 5, eq. 3)."""
    masks, mesh = region_masks(face), neutral.artist.mesh
    areas = mass(mesh.vertices, mesh.faces)
    regions = [regions_of(s.name, s.delta, masks, areas) if config.masks else tuple(masks) for s in shapes]
    deltas = [masked(s.delta, where, masks) for s, where in zip(shapes, regions, strict=True)]
    names = tuple(shape.name for shape in shapes)
    rig = Rig(mesh, np.array(deltas).reshape(-1, len(mesh.vertices), 3), names, as_bytes(neutral.texture))
    size = config.texture
    textures = np.array([as_bytes(s.texture) for s in shapes], np.uint8).reshape(-1, size, size, 3)
    drawn = mask_textures(mesh, masks, size)
    return TexturedRig(rig, textures, names, tuple(regions), drawn, np.eye(len(names)))


def completed(
    textured: TexturedRig, neutral: NeutralFace, shapes: Sequence[BuiltShape], face: BundledFace, config: RigConfig
) -> TexturedRig:
    """The 52 ARKit shapes, pulled to the captures; captures of other names stay as targets of their own."""
    mesh = neutral.artist.mesh
    examples = textured.rig.deltas
    areas = mass(mesh.vertices, mesh.faces) * face.regions["face"] + 1e-6
    found = complete_arkit(neutral.units, textured.captures, examples, areas, config.complete)
    others = [i for i, name in enumerate(textured.captures) if name not in ARKIT_NAMES]
    names = (*ARKIT_NAMES, *(textured.captures[i] for i in others))
    rig = Rig(mesh, np.concatenate([found.deltas, examples[others]]), names, textured.rig.texture)
    mixes = np.pad(found.mixes, ((0, 0), (0, len(others))))
    return TexturedRig(rig, textured.textures, textured.captures, textured.regions, textured.mask_textures, mixes)
