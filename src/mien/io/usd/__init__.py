"""Rigs and performances as USD (`.usd`, `.usda`, `.usdc`, `.usdz`), out and in again. Needs the extra `usd`.

What is written: a `SkelRoot` with one mesh, a `BlendShape` for every shape, a skeleton of one joint (`head`) that bears
the head's pose, and a `SkelAnimation` with weights and pose at whole time codes from 0 on. Metres, +Y up, triangles
(no subdivision), `timeCodesPerSecond` the performance's rate. Texture coordinates go corner by corner, as the rig has
them. Blend shapes carry `normalOffsets`, and none has inbetweens.

USD wants identifiers as names of prims; the rig's own names are the tokens of `skel:blendShapes`, which may be any
text, and those are read.
"""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from ...extras import require
from ...files import note_clock
from ...progress import unheard
from ...rig import Performance, Rig

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")


def write_rig(path: str | Path, rig: Rig) -> None:
    """Write a rig; a texture goes beside it as `NAME.base_color.png`, for `.usdz` into the package.

    Raises:
        BadInput: the extra is missing, or the folder does not exist.
    """
    require("pxr", "usd")
    from .write import write_face

    write_face(Path(path), rig, None)


def write_performance(
    path: str | Path, performance: Performance, heights: Iterable[Float32[np.ndarray, "h w"]] = ()
) -> None:
    """Write a performance: its rig, weights (in 0..1, `rig.unit_weights`) and the head's pose.

    Args:
        heights: displacement maps of the rig's texture coordinates, along the normal, mm: one a frame, or one for all.
            They go beside the file as `NAME.displacement/000000.exr`, ..., for `.usdz` into the package.

    Raises:
        ValueError: the head pose scales, or there is no frame.
        BadInput: the extra is missing, or the folder does not exist.
    """
    if performance.T_world_face.scale != 1.0 or len(performance) == 0:
        raise ValueError("T_world_face, weights: expected one rigid pose a frame and at least one frame")
    require("pxr", "usd")
    from ...rig.unit_weights import with_unit_weights
    from .write import write_face

    unit = with_unit_weights(performance)
    write_face(Path(path), unit.rig, unit, heights)
    note_clock(path, unit.rate, len(unit))


def read_rig(path: str | Path, tell: Callable[[str], None] = unheard) -> Rig:
    """The rig of a USD file of any program: the mesh with the most blend shapes, as it stands at rest, millimetres.

    Polygons become triangles; units and up axis are the stage's. `tell` hears what is left out (inbetweens,
    displacement).

    Raises:
        BadInput: the extra is missing; missing, damaged, without blend shapes, or with shapes of another vertex count.
    """
    require("pxr", "usd")
    from .read import open_face

    return open_face(Path(path), tell).rig()


def read_performance(path: str | Path, tell: Callable[[str], None] = unheard) -> Performance:
    """The rig of a USD file (`read_rig`) and the animation of its blend shapes and of what moves its mesh.

    A mesh that is skinned moves with the joint that it hangs on most.

    Raises:
        BadInput: as `read_rig`; nothing animates the blend shapes; the head changes size.
    """
    require("pxr", "usd")
    from .read import open_face

    return open_face(Path(path), tell).performance()


def read_displacement(path: str | Path) -> Iterator[Float32[np.ndarray, "h w"]]:
    """The displacement maps of a USD file's face, along the normal, mm: one a frame, one for all, or none.

    Raises:
        BadInput: as `read_rig`; a map is missing or no EXR.
    """
    require("pxr", "usd")
    from .read import open_face

    return open_face(Path(path), unheard).heights()


def is_animated(path: str | Path) -> bool:
    """Whether something animates the blend shapes; nothing but the stage's index is read. Errors as `read_rig`."""
    require("pxr", "usd")
    from .read import open_face

    return open_face(Path(path), unheard).is_animated()
