"""Built expressions to one rig with masks, and to all 52 ARKit shapes (Casas et al. 2016, sec. 5)."""

from collections.abc import Sequence

import numpy as np

from ..faces.arkit import ARKIT_NAMES
from ..faces.bundled import BundledFace
from ..mesh import mass
from ..rig import Rig
from .build.arkit import complete_arkit
from .build.masks import TexturedRig, mask_textures, masked, region_masks, regions_of
from .build.texture import as_bytes
from .expression import BuiltShape, NeutralFace, RigConfig


def with_masks(neutral: NeutralFace, shapes: Sequence[BuiltShape], face: BundledFace, config: RigConfig) -> TexturedRig:
    """Delta shapes and textures with their masks (sec. 5, eq. 3)."""
    masks, mesh = {name: neutral.on_rig(mask) for name, mask in region_masks(face).items()}, neutral.mesh
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
    mesh = neutral.mesh
    examples = textured.rig.deltas
    areas = mass(mesh.vertices, mesh.faces) * neutral.on_rig(face.regions["face"]) + 1e-6
    units = np.moveaxis(neutral.on_rig(np.moveaxis(neutral.units, 0, 1)), 1, 0)
    found = complete_arkit(units, textured.captures, examples, areas, config.complete)
    others = [i for i, name in enumerate(textured.captures) if name not in ARKIT_NAMES]
    names = (*ARKIT_NAMES, *(textured.captures[i] for i in others))
    rig = Rig(mesh, np.concatenate([found.deltas, examples[others]]), names, textured.rig.texture)
    mixes = np.pad(found.mixes, ((0, 0), (0, len(others))))
    return TexturedRig(rig, textured.textures, textured.captures, textured.regions, textured.mask_textures, mixes)
