"""One capture on the neutral's artist mesh: aligned, warped, looked up (Casas et al. 2016, sec. 3 to 5.1)."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..mesh import Mesh, mass
from ..transforms import Transform
from .align import HeadAlignConfig, align, stabilised
from .build.arkit import CompleteConfig, transferred
from .build.artist_mesh import ArtistMesh, bundled_mesh, complete, look_up
from .build.own_mesh import OwnMesh, own_mesh, taken_on, thinned
from .build.texture import TexelGrid, expression_texture, neutral_texture, texel_grid
from .corrections import NOTHING, Correction, Pins, landmarks_by_hand, pinned, pins_by_hand
from .correspond.dense import SkinWarp, WarpConfig, warp
from .correspond.landmarks import MapLandmarks, along_contours
from .correspond.model_motion import mix_of, motion_image
from .correspond.occlusion import wires, without
from .cylinder_map import CylinderMap

BUNDLED, AUTO = "bundled", "auto"
"""The rig's mesh: the bundled topology, or the neutral thinned by itself."""
SAME_MM, SAME_SHARE = 1.0, 0.12
"""Of one person's face at least this share lies within so many mm of the neutral: 0.57 of a staged smile, 0.25 of a
mouth wide open, but 0.06 of another person's face."""


@dataclass(frozen=True)
class RigConfig:
    """How captures become a rig."""

    texture: int = 1024
    """Texels a side."""
    triangles: int = 9000
    """Of a mesh that is thinned by itself (`--artist auto`)."""
    model: bool = True
    """The bundled expressions' motion starts the warp where no landmark is; off: the paper's triangles alone."""
    stabilise: bool = True
    """The head is held still by all skin that does not move; off: by the forehead alone, as in the paper."""
    worn: bool = True
    """Rims of glasses and the like are taken out of every capture; off: they stay."""
    masks: bool = True
    """Expressions are kept to the regions that they move."""
    align: HeadAlignConfig = field(default_factory=HeadAlignConfig)
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
    pins: Pins = field(default_factory=dict)
    own: OwnMesh | None = None
    """What the rig is made on, where it is not the bundled topology."""

    @property
    def mesh(self) -> Mesh:
        """The rig's neutral."""
        return self.artist.mesh if self.own is None else self.own.artist.mesh

    def on_rig(self, values: Float[np.ndarray, "bundled *c"]) -> Float[np.ndarray, "n *c"]:
        """Values of the bundled topology's vertices at the rig's."""
        return values if self.own is None else self.own.of_bundled(values)


@dataclass(frozen=True)
class BuiltShape:
    """One expression on the rig's mesh."""

    name: str
    delta: Float[np.ndarray, "n 3"]
    """Mm, whole."""
    texture: Float[np.ndarray, "h w 3"]
    seen: Bool[np.ndarray, " n"]
    """Vertices that the capture shows."""
    map: CylinderMap
    """The capture in the neutral's frame."""
    warp: SkinWarp
    landmarks: int
    """How many are known in both."""
    rms_mm: float
    """Of the forehead after ICP, mm."""


def neutral_face(
    map_: CylinderMap,
    face: BundledFace,
    config: RigConfig,
    by_hand: Correction = NOTHING,
    on: Mesh | Literal["bundled", "auto"] = BUNDLED,
) -> NeutralFace:
    """Landmarks, artist mesh and base texture of the neutral (sec. 4.2 and 5.1).

    on: what the rig is made on: the bundled topology, the neutral thinned by itself, or a mesh that lies on it.

    Raises:
        BadInput: no face, or a mesh that does not lie on it.
    """
    landmarks = landmarks_by_hand(map_, by_hand)
    map_ = bare(map_, landmarks, config)
    artist = bundled_mesh(map_, landmarks, face)
    units = transferred(face, artist.mesh)
    own = None
    if on != BUNDLED:
        mesh = thinned(map_, landmarks, config.triangles) if on == AUTO else on
        own = own_mesh(mesh, map_, artist, face.skin_faces)
    drawn = artist if own is None else own.artist
    grid = texel_grid(drawn.mesh, drawn.shown, map_, config.texture)
    pins = pins_by_hand(map_, by_hand)
    return NeutralFace(map_, landmarks, artist, units, grid, neutral_texture(grid, map_), pins, own)


def build_shape(
    map_: CylinderMap,
    neutral: NeutralFace,
    face: BundledFace,
    config: RigConfig,
    by_hand: Correction = NOTHING,
) -> BuiltShape:
    """One capture: aligned by the forehead, warped to the neutral, looked up on the artist mesh (sec. 3 to 5.1).

    Raises:
        BadInput: no face, no forehead, or too few landmarks.
    """
    landmarks = landmarks_by_hand(map_, by_hand)
    map_ = bare(map_, landmarks, config)
    aligned = align(map_, landmarks, neutral.map, neutral.landmarks, config.align)
    artist, expected = neutral.artist, None
    if config.model:
        mix = mix_of(neutral.units, artist.mesh, aligned.landmarks, neutral.landmarks)
        expected = motion_image(artist.mesh, np.tensordot(mix, neutral.units, axes=1), neutral.map.layout)
    T, own = aligned.T_neutral_capture, pins_by_hand(map_, by_hand)
    pins = {name: T.apply(point[None])[0] for name, point in own.items()}
    warped = warp(
        source=aligned.map,
        source_landmarks=aligned.landmarks,
        neutral=neutral.map,
        neutral_landmarks=neutral.landmarks,
        expected=expected,
        pinned=pinned(neutral.pins, pins, neutral.map.layout),
        config=config.warp,
    )
    found = look_up(artist, aligned.map, warped)
    marks, still = aligned.landmarks, Transform.identity()
    if config.stabilise:
        share = mass(artist.mesh.vertices, artist.mesh.faces) * face.regions["face"]
        still = stabilised(found, artist.mesh.vertices, share)
        found, marks = still.apply(found), marks.moved(still)
        check_person(map_.name, found, artist.mesh.vertices, share)
    seen = np.isfinite(found[:, 0])
    if not seen.any():
        raise BadInput(f"{map_.name}: shows nothing of the face that the neutral shows")
    if neutral.own is None:
        edges = along_contours(artist.mesh.vertices, face.contours, marks, neutral.landmarks)
        delta, _ = complete(artist, found, face, neutral.units, edges)
    else:
        delta, seen = taken_on(neutral.own, aligned.map, warped, still)
    texture, _ = expression_texture(neutral.grid, aligned.map, warped, neutral.texture)
    known = int((aligned.landmarks.known & neutral.landmarks.known).sum())
    return BuiltShape(map_.name, delta, texture, seen, aligned.map, warped, known, aligned.rms_mm)


def bare(map_: CylinderMap, landmarks: MapLandmarks, config: RigConfig) -> CylinderMap:
    """The capture without what is worn before the face."""
    return without(map_, wires(map_, landmarks.pixels(map_.layout))) if config.worn else map_


def check_person(
    name: str,
    found: Float[np.ndarray, "n 3"],
    neutral: Float[np.ndarray, "n 3"],
    share: Float[np.ndarray, " n"],
) -> None:
    """Whether a capture, its head held still, shows the person of the neutral.

    Raises:
        BadInput: too little of the face is where the neutral has it.
    """
    seen = np.isfinite(found[:, 0]) & (share > 0)
    off = np.linalg.norm(found[seen] - neutral[seen], axis=1)
    same = share[seen][off < SAME_MM].sum() / max(share[seen].sum(), 1e-9)
    if seen.any() and same < SAME_SHARE:
        raise BadInput(
            f"{name}: {same:.0%} of the face lies where the neutral's does; is it another person, or the wrong unit?"
        )
