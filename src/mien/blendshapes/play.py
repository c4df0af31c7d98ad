"""A performance on a textured rig: which texture each frame has (Casas et al. 2016, sec. 5.2 and 6)."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from ..errors import BadInput
from ..files import existing
from ..rig import Performance
from .build.masks import TexturedRig, texture_weights
from .build.rig_files import read_textured_rig, record_of


def textures_of(performance: Performance, path: Path) -> Callable[[int], UInt8[np.ndarray, "h w 3"]]:
    """A frame's number -> its texture, by the captures that its weights are mixes of (Casas et al. 2016, sec. 5.2).

    Raises:
        BadInput: as `textured_for`.
    """
    textured = textured_for(performance, path)
    played = {name: i for i, name in enumerate(performance.rig.names)}
    weights = np.zeros((len(performance), len(textured.rig.names)))
    for row, name in enumerate(textured.rig.names):
        if name in played:
            weights[:, row] = performance.weights[:, played[name]]
    shares = texture_weights(weights, textured.mixes)
    return lambda frame: textured.texture(shares[frame])


def textured_for(performance: Performance, path: Path) -> TexturedRig:
    """The rig at `path` with its textures, that the performance plays on.

    Raises:
        BadInput: the rig has no textures beside it, or none of its shapes is played.
    """
    textured = read_textured_rig(existing(path))
    if textured is None:
        raise BadInput(f"{path}: has no textures beside it ({record_of(path).name}); make it with `mien rig`")
    if performance.rig.neutral.uv is None or not set(textured.rig.names) & set(performance.rig.names):
        raise BadInput(f"{path}: the performance plays none of its shapes; track it with --rig {path.name}")
    return textured
