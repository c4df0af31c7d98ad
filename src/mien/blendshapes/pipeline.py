"""Captures to a rig whose textures blend with its shapes (Casas et al. 2016, fig. 2)."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..one_line import one_line
from ..progress import SILENT, Progress
from .assemble import completed, with_masks
from .build.masks import TexturedRig
from .captures import Capture
from .expression import BuiltShape, NeutralFace, RigConfig, build_shape, neutral_face


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
