"""From a marker take to `selection.json`: what is analysed, what is left out, and the file."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from ...clip import Markers
from ...errors import BadInput
from ...files import existing, whole
from ...one_line import one_line
from ...progress import SILENT, Progress
from ...takes.preprocess import PreprocessTakeConfig, preprocess_take
from .marker_reduction import MarkerStudy
from .select_frames import SelectConfig, Selection, select_frames


@dataclass(frozen=True)
class SelectTakeConfig:
    """Everything that `mien select` may be told."""

    preprocess: PreprocessTakeConfig = PreprocessTakeConfig()
    select: SelectConfig = SelectConfig()


@dataclass(frozen=True)
class TakeSelection:
    """Frames to scan, and what they were chosen from."""

    selection: Selection
    """Its frames count in the take; its weights have a row for each of `analysed`."""
    positions: Float[np.ndarray, "analysed markers 3"]
    """In the head's frame, gaps filled, mm."""
    analysed: Int[np.ndarray, " analysed"]
    """Frames of the take that were looked at."""
    labels: tuple[str, ...]
    """Markers that were looked at."""
    left_out: tuple[str, ...]
    """Markers that were not."""

    def __repr__(self) -> str:
        frames = ", ".join(map(str, self.selection.frames.tolist()))
        return one_line(self, f"frames {frames}", f"mean marker error {self.selection.errors[-1]:.3f} mm")

    @property
    def bases(self) -> Int[np.ndarray, " chosen"]:
        """The chosen frames as rows of `positions`."""
        return np.searchsorted(self.analysed, self.selection.frames)


def select_take(
    markers: Markers, config: SelectTakeConfig = SelectTakeConfig(), progress: Progress = SILENT
) -> TakeSelection:
    """Huang et al. 2011, sec. 4, on a take as it was recorded: head motion out, gaps filled, frames chosen.

    Raises:
        BadInput: too little of the take was seen.
    """
    take = preprocess_take(markers, config.preprocess)
    analysed, filled = take.analysed, take.positions
    selection = select_frames(filled[analysed], config.select, progress)
    selection = replace(selection, frames=analysed[selection.frames])
    return TakeSelection(selection, filled[analysed], analysed, take.markers.labels, take.left_out)


@dataclass(frozen=True)
class SelectionFile:
    """What `selection.json` holds."""

    frames: tuple[int, ...]
    """Frames of the take, counted from 0, in the order of choice."""
    errors: tuple[float, ...]
    """Mean marker error with the first 1, 2, ... of them, as a part of the diagonal."""
    tolerance: float
    take: str
    """Name of the take's file."""


def read_selection(path: str | Path) -> SelectionFile:
    """Read what `write_selection` wrote, or what somebody wrote by hand: `frames` alone is enough.

    Raises:
        BadInput: no such file, not JSON, frames that are not whole numbers from 0 up or appear twice.
    """
    try:
        found = json.loads(existing(path).read_text())
        frames = found["frames"]
        if not frames or not all(type(f) is int and f >= 0 for f in frames):
            raise TypeError
        errors = tuple(float(e) for e in found.get("errors", ()))
        tolerance, take = float(found.get("tolerance", SelectConfig.tolerance)), str(found.get("take", ""))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not a JSON file ({error})") from None
    except (TypeError, KeyError, AttributeError, ValueError):
        raise BadInput(f'{path}: expected {{"frames": [12, 840, ...]}}, frames counted from 0') from None
    if len(set(frames)) < len(frames):
        raise BadInput(f"{path}: a frame is listed twice; every frame is scanned once")
    return SelectionFile(tuple(frames), errors, tolerance, take)


def write_selection(path: str | Path, take: str, found: TakeSelection, study: MarkerStudy | None = None) -> None:
    """Write `selection.json`: frames, error curve, tolerance, take; with a study, markers in the order to spare them.

    `errors` are parts of the diagonal, as the tolerance is; `errors_mm` the same in millimetres; `strongest` are those
    of the strongest tenth of the frames, as parts of how far they are from the take's mean face.
    """
    selection = found.selection
    content = {
        "take": take,
        "frames": selection.frames.tolist(),
        "errors": [round(e, 7) for e in selection.relative.tolist()],
        "tolerance": selection.tolerance,
        "errors_mm": [round(e, 5) for e in selection.errors.tolist()],
        "strongest": [round(e, 5) for e in selection.strongest.tolist()],
        "diagonal_mm": round(selection.diagonal, 3),
        "markers": {"used": list(found.labels), "left_out": list(found.left_out)},
    }
    if study is not None:
        content["markers"]["spare_first"] = [found.labels[m] for m in study.removed]
        content["markers"]["errors_mm"] = [round(e, 5) for e in study.errors.tolist()]
    with whole(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n")
