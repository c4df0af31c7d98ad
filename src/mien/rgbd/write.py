"""Writing the folder form of a take."""

import json
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image

from ..errors import BadInput
from ..files import whole
from ..progress import SILENT, Progress
from .intrinsics import write_intrinsics
from .take import RgbdTake


def write_rgbd(
    folder: str | Path,
    take: RgbdTake,
    depth_scale: float = 1000.0,
    color: Literal["png", "jpg"] = "png",
    progress: Progress = SILENT,
) -> None:
    """Write the folder form: color/, depth/ (16-bit PNG), camera_intrinsic.json, take.json, timestamps.csv.

    PNG keeps colour exactly; JPEG (quality 95) is a fifth of the size. Frames of an older take there are removed.

    Raises:
        BadInput: the folder's parent does not exist, or a depth does not fit in 16 bits at this scale.
    """
    folder = Path(folder)
    if not folder.parent.is_dir():
        raise BadInput(f"{folder}: the folder {folder.parent} does not exist; create it first")
    for part in (folder / "color", folder / "depth"):
        part.mkdir(parents=True, exist_ok=True)
        for old in part.glob("[0-9]*.*"):
            old.unlink()
    write_intrinsics(folder / "camera_intrinsic.json", take.camera)
    (folder / "take.json").write_text(json.dumps({"depth_scale": depth_scale, "fps": take.rate}))
    times = []
    for i, frame in enumerate(take):
        if frame.color is not None:
            file = folder / "color" / f"{i:06d}.{color}"
            Image.fromarray(frame.color).save(file, compress_level=1, quality=95)
        if frame.depth is not None:
            units = np.nan_to_num(frame.depth) * (depth_scale / 1000)
            if units.max(initial=0) > 65535:
                raise BadInput(f"{folder}: depth of {frame.depth.max():.0f} mm does not fit 16 bits; lower depth_scale")
            values = np.round(units).astype(np.uint16)
            Image.fromarray(values).save(folder / "depth" / f"{i:06d}.png", compress_level=1)
        times.append(frame.time)
        progress.update("writing the take", i + 1, take.count)
    with whole(folder / "timestamps.csv") as temporary:
        temporary.write_text("frame,seconds\n" + "".join(f"{i},{t:.6f}\n" for i, t in enumerate(times)))
