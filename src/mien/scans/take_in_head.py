"""The selected frames of a take, seen from its head, and the scans that show them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..takes.preprocess import PreprocessedTake
from ..takes.stabilise import calm_frames, mean_cloud
from .fitted_scan import FittedScan
from .left_out import LeftOut, enough, kept

HALF_WINDOW_S = 0.05
"""A parabola is laid through so much before and after a frame, seconds: faces move little faster."""


@dataclass(frozen=True)
class TakeInHead:
    """Markers of the selected frames, and the scans of the same expressions: the neutral one first."""

    labels: tuple[str, ...]
    """Markers that were seen often enough."""
    scans: tuple[FittedScan, ...]
    expressions: Float[np.ndarray, "scans markers 3"]
    """Head frame of the take, mm; a row a scan."""
    left_out: tuple[LeftOut, ...] = ()

    def only(self, rows: Sequence[int], left_out: tuple[LeftOut, ...]) -> "TakeInHead":
        """The same with these scans alone."""
        scans = tuple(self.scans[i] for i in rows)
        return TakeInHead(self.labels, scans, self.expressions[list(rows)], self.left_out + left_out)


def take_in_head(take: PreprocessedTake, scans: Sequence[FittedScan], strict: bool = False) -> TakeInHead:
    """Scans whose frames the take shows, with their markers.

    Raises:
        BadInput: none is left, or one is left out and `strict` forbids it.
    """
    found, out = kept([_in_take(take, scan) for scan in scans], strict)
    enough(len(found), 1, out)
    ordered = neutral_first(take, found)
    expressions = denoise_frames(take.positions, [scan.frame for scan in ordered], take.markers.rate)
    return TakeInHead(take.markers.labels, tuple(ordered), expressions, out)


def _in_take(take: PreprocessedTake, scan: FittedScan) -> FittedScan | LeftOut:
    if scan.frame in take.analysed:
        return scan
    return LeftOut(
        scan.name,
        f"frame {scan.frame} is not in the take or shows too few markers (it has {len(take.positions)} frames); is it "
        "the take that the selection was made from?",
    )


def neutral_first(take: PreprocessedTake, scans: Sequence[FittedScan]) -> list[FittedScan]:
    """Scans with the one closest to the take's calm face in front, of those in which a face was found if any was."""
    calm = mean_cloud(take.positions, calm_frames(take.positions)[0])
    frames = [scan.frame for scan in scans]
    away = np.linalg.norm(take.positions[frames] - calm, axis=2).mean(axis=1)
    known = np.array([scan.fit is not None for scan in scans])
    neutral = int(np.where(known | ~known.any(), away, np.inf).argmin())
    return [scans[neutral], *(scan for i, scan in enumerate(scans) if i != neutral)]


def denoise_frames(
    positions: Float[np.ndarray, "frames markers 3"], frames: Sequence[int], rate: float
) -> Float[np.ndarray, "chosen markers 3"]:
    """The markers of selected frames, the neutral one first, with less jitter, mm: scans will meet them exactly.

    The neutral frame is averaged with those most like it; a parabola through a tenth of a second smooths the others.
    """
    reach = max(1, round(HALF_WINDOW_S * rate))
    quiet = [_at_parabola(positions, frame, reach) for frame in frames[1:]]
    return np.stack([mean_cloud(positions, frames[0]), *quiet])


def _at_parabola(
    positions: Float[np.ndarray, "frames markers 3"], frame: int, reach: int
) -> Float[np.ndarray, "markers 3"]:
    """Where parabolas through `reach` frames before and after have the markers at `frame`."""
    near = np.arange(max(0, frame - reach), min(len(positions), frame + reach + 1))
    near = near[np.isfinite(positions[near]).all(axis=(1, 2))]
    time = (near - frame) / reach
    powers = time[:, None] ** np.arange(min(3, len(near)))
    at_frame = np.linalg.pinv(powers)[0]
    return np.tensordot(at_frame, positions[near], axes=1)
