"""What one capture becomes: points, normals and albedo on the first camera's pixels."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from ...errors import BadInput
from ...io.exr import read_exr, write_exr
from ...mesh import Mesh, grid_faces
from ...one_line import count, one_line
from ..cut_out import Box


@dataclass(frozen=True)
class LightScan:
    """A detailed scan, laid out in the first camera's picture; NaN where nothing is known."""

    points: Float[np.ndarray, "h w 3"]
    """Rig space (the first camera's: x right, y down, z forward), mm."""
    normals: Float[np.ndarray, "h w 3"]
    albedo: Float[np.ndarray, "h w"]
    """Up to one factor; also where there is light and no point."""
    confidence: Float[np.ndarray, "h w"]
    """Of the normals, 0..1; 1 where there were no gradients to judge by."""
    sigma_mm: Float[np.ndarray, "h w"]
    """Standard deviation of the depth before fusion."""

    def __repr__(self) -> str:
        z = np.nanmedian(self.points[..., 2]) if self.known.any() else np.nan
        return one_line(self, count(int(self.known.sum()), "points"), f"about {z:.0f} mm away")

    def in_whole_picture(self, box: Box, size: tuple[int, int]) -> "LightScan":
        """Laid out in the whole picture, of `size` rows and columns, that it is the cut-out `box` of."""
        fields = {}
        for name, values in vars(self).items():
            nothing = 0.0 if name == "confidence" else np.nan
            whole = np.full((*size, *values.shape[2:]), nothing)
            whole[box.slices] = values
            fields[name] = whole
        return LightScan(**fields)

    @property
    def known(self) -> Bool[np.ndarray, "h w"]:
        """Pixels that have a point."""
        return np.all(np.isfinite(self.points), axis=-1)

    def mesh(self, longest_mm: float = 3.0) -> Mesh:
        """Neighbouring pixels joined by triangles, none with an edge longer than `longest_mm`; grey vertex colours."""
        known = self.known
        number = np.cumsum(known) - 1
        faces = number[grid_faces(self.points, longest_mm)]
        grey = np.nan_to_num(self.albedo[known])
        shade = np.clip(grey / max(float(np.quantile(grey, 0.98)), 1e-9), 0, 1) ** (1 / 2.2) if len(grey) else grey
        return Mesh(self.points[known], faces, colors=np.repeat(shade[:, None], 3, axis=1))


CHANNELS = {"points": ("P.X", "P.Y", "P.Z"), "normals": ("N.X", "N.Y", "N.Z")}
SINGLE = {"albedo": "albedo", "confidence": "confidence", "sigma_mm": "sigma"}


def write_light_scan(path: str | Path, scan: LightScan) -> None:
    """As EXR, 32-bit float: P.X, P.Y, P.Z (mm), N.X, N.Y, N.Z, albedo, confidence, sigma (mm)."""
    channels = {}
    for field, names in CHANNELS.items():
        for i, name in enumerate(names):
            channels[name] = getattr(scan, field)[..., i].astype(np.float32)
    for field, name in SINGLE.items():
        channels[name] = getattr(scan, field).astype(np.float32)
    write_exr(path, channels)


def read_light_scan(path: str | Path) -> LightScan:
    """What `write_light_scan` has left.

    Raises:
        BadInput: no such file, or an EXR of another kind.
    """
    channels = read_exr(path)
    names = [name for group in CHANNELS.values() for name in group] + list(SINGLE.values())
    missing = [name for name in names if name not in channels]
    if missing:
        raise BadInput(f"{path}: no scan of active light: channels {', '.join(missing)} are missing")
    fields = {
        field: np.stack([channels[name] for name in group], -1).astype(float) for field, group in CHANNELS.items()
    }
    fields |= {field: channels[name].astype(float) for field, name in SINGLE.items()}
    return LightScan(**fields)
