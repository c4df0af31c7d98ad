"""Captures to a rig whose textures blend with its shapes (Casas et al. 2016, fig. 2)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..mesh import Mesh
from ..one_line import one_line
from ..progress import SILENT, Progress
from .assemble import completed, with_masks
from .build.lower_teeth import lower_teeth_behind_skin
from .build.masks import TexturedRig
from .captures import Capture
from .corrections import NOTHING, Correction, without_painted
from .expression import BUNDLED, BuiltShape, NeutralFace, RigConfig, build_shape, neutral_face


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
    corrections: Mapping[str, Correction] = MappingProxyType({}),
    on: Mesh | Literal["bundled", "auto"] = BUNDLED,
) -> BuiltRig:
    """The neutral on the artist mesh, then every expression on it, then masks; `arkit` completes the 52.

    corrections: by the captures' names, what is said by hand.
    on: what the rig is made on (`neutral_face`).

    Raises:
        BadInput: the neutral cannot be used, or no capture bears its name. Another that cannot be used is left out.
    """
    named = {capture.name: capture.map for capture in captures}
    progress.update("the neutral face", 0, 1)
    by_hand = corrections.get(neutral, NOTHING)
    rest = without_painted(named.pop(neutral), by_hand)
    calm = neutral_face(
        map_=rest,
        face=face,
        config=config,
        by_hand=by_hand,
        on=on,
    )
    progress.update("the neutral face", 1, 1)
    shapes, left_out = [], []
    for done, (name, map_) in enumerate(named.items()):
        progress.update("expressions", done, len(named))
        by_hand = corrections.get(name, NOTHING)
        try:
            painted = without_painted(map_, by_hand)
            shape = build_shape(painted, calm, face, config, by_hand=by_hand)
            shapes.append(shape)
        except BadInput as error:
            left_out.append(f"left out: {error}")
    progress.update("expressions", len(named), len(named))
    textured = with_masks(calm, shapes, face, config)
    if arkit:
        textured = completed(textured, calm, shapes, face, config)
    if calm.own is None:
        textured = replace(textured, rig=lower_teeth_behind_skin(textured.rig, face))
    return BuiltRig(textured, calm, tuple(shapes), tuple(left_out))
