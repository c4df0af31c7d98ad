"""A folder of pictures of a face, each lit by one lamp whose place lights.json tells."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from ...camera import Camera
from ...errors import BadInput
from ...files import existing
from ..near_light import NearLightConfig, near_light_surface, read_lamps
from ..normals import PointLamp
from ..triangulate import pixel_rays
from .light_scan import LightScan
from .light_take import DARK, one_size, read_grey

SCALED = 0.9
"""Of full scale, to which the brightest picture's bright pixels are brought: shadows are shares of what is lit."""
MASKED = 0.05
"""Of the bright pixels' mean over all lamps; what is darker is no face, where no mask.png says so."""


@dataclass(frozen=True)
class LampTake:
    """Pictures under one lamp after the other, linear, light of the room taken off."""

    images: Float[np.ndarray, "lamps h w"]
    lamps: list[PointLamp]
    camera: Camera
    mask: Bool[np.ndarray, "h w"]


def read_lamp_take(folder: str | Path, gamma: float = 2.2) -> LampTake:
    """`lights.json` names lamps, their pictures and K; `ambient.png` (no lamp) and `mask.png` stand beside it or not.

    Raises:
        BadInput: a picture is missing, of another size or black, or there are fewer than three lamps.
    """
    folder = existing(folder)
    lamps, names, K = read_lamps(folder / "lights.json")
    if len(lamps) < 3:
        raise BadInput(f"{folder / 'lights.json'}: {len(lamps)} lamps; normals need 3 or more")
    paths = [folder / name for name in names]
    beside = [folder / name for name in ("ambient.png", "mask.png") if (folder / name).is_file()]
    read = [read_grey(existing(path), gamma) for path in (*paths, *beside)]
    one_size(read, (*paths, *beside))
    for path, image in zip(paths, read, strict=False):
        if np.quantile(image, 0.995) < DARK / 10:
            raise BadInput(f"{path}: black; did its lamp flash?")
    extra = dict(zip((path.stem for path in beside), read[len(paths) :], strict=True))
    images = np.clip(np.stack(read[: len(paths)]) - extra.get("ambient", 0.0), 0, None)
    mean = images.mean(axis=0)
    mask = extra["mask"] > 0.5 if "mask" in extra else mean > MASKED * np.quantile(mean, 0.99)
    if not mask.any():
        raise BadInput(f"{folder}: mask.png leaves no pixel, or the lamps light none")
    images = images * SCALED / max(float(np.quantile(images[:, mask], 0.999)), 1e-9)
    height, width = mask.shape
    return LampTake(images, lamps, Camera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], width, height), mask)


def lamp_scan(take: LampTake, config: NearLightConfig = NearLightConfig()) -> tuple[LightScan, str]:
    """The surface and normals as a scan, and a line on how far away it is and how well lamps explain the pictures.

    Raises:
        BadInput: as `near_light_surface`.
    """
    found = near_light_surface(take.images, take.lamps, take.camera, take.mask, config)
    light = found.light
    points = pixel_rays(take.camera) * found.z[..., None]
    scan = LightScan(points, light.normals, light.albedo, light.confidence, np.full(found.z.shape, np.nan))
    words = f"{len(take.lamps)} lamps: {found.mean_mm:.0f} mm away by their fall-off, {found.residual:.0%} unexplained"
    return scan, words
