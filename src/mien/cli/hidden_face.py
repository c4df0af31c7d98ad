"""What `mien track --hidden upper` needs besides the take: gauges, and a clip in which they and the face were seen."""

import sys
from dataclasses import dataclass
from pathlib import Path

from ..errors import BadInput
from ..io.gauge_file import GaugeTable, read_gauges
from ..io.performances import read_any_performance
from ..rgbd import RgbdTake
from ..rig import Performance
from ..tracking.hidden.gauge_regression import GaugeRegression, check_overlap, drive_upper, learn_gauges
from .options import refuse_unused
from .play import tell


@dataclass(frozen=True)
class GaugeOptions:
    """Channels that tell a hidden upper face."""

    gauges: Path | None = None
    """With --hidden upper: channels read beside the take, strain gauges say (.csv: a time column in seconds from the
    take's first frame, then any columns). They drive brows, lids and cheeks."""
    calibration: Path | None = None
    """An animated face (.glb) tracked while all of it was seen and the same gauges were read."""
    calibration_gauges: Path | None = None
    """What they read then (.csv)."""

    @property
    def inputs(self) -> list[Path | None]:
        """The files."""
        return [self.gauges, self.calibration, self.calibration_gauges]


@dataclass(frozen=True)
class Gauges:
    """Gauges of a take, and what was learnt of them."""

    table: GaugeTable
    regression: GaugeRegression

    def driven(self, performance: Performance) -> Performance:
        """The performance, its upper shapes as the gauges say."""
        return drive_upper(performance, self.regression, self.table)


def learnt_gauges(options: GaugeOptions, hidden: str | None, take: RgbdTake) -> Gauges | None:
    """Read and learn before the take is tracked; None where no gauges are given. What was left out is told.

    Raises:
        BadInput: options that do not go together, or files that do not.
    """
    if hidden is None:
        refuse_unused("without --hidden upper", "upper")
        return None
    if not take.has_depth:
        raise BadInput(f"{take.name}: --hidden needs an RGB-D take; what is seen of the face is fitted to its depth")
    given = [path for path in options.inputs if path is not None]
    if not given:
        tell("no --gauges: brows, lids and cheeks stay at rest")
        return None
    if options.gauges is None or options.calibration is None or options.calibration_gauges is None:
        raise BadInput(
            "--gauges, --calibration and --calibration-gauges go together: readings of this take, and an animated face "
            "with the readings of its own take"
        )
    table = read_gauges(options.gauges)
    without = check_overlap(table, take.count, take.rate)
    if without:
        tell(f"{table.name}: {without} of {take.count} frames have no reading; they hold the nearest")
    calibration = read_any_performance(options.calibration, tell)
    regression = learn_gauges(calibration, read_gauges(options.calibration_gauges), table)
    for note in regression.notes:
        tell(note)
    told_regression(regression)
    return Gauges(table, regression)


def told_regression(regression: GaugeRegression) -> None:
    """Held-out errors, a line a shape."""
    print("upper shapes: rms error on held-out parts of the calibration, beside that of their mean", file=sys.stderr)
    for name, error, frozen in zip(regression.shapes, regression.errors, regression.frozen, strict=True):
        print(f"  {name:18} {error:.3f}  {frozen:.3f}", file=sys.stderr)
