"""The paper's two halves in its order: training (fig. 2) and synthesis (sec. 5)."""

from collections.abc import Iterator

from ..clip import Markers
from ..progress import SILENT, Progress
from ..rig import Performance
from .drive import Drive, drive_by_markers, drive_by_performance
from .fit import DetailConfig, DetailModel, fit_detail
from .synthesize import SynthesisConfig, SynthesizedFrame, Synthesizer
from .transfer.markers_elsewhere import place_markers

__all__ = ["DetailConfig", "DetailModel", "SynthesisConfig", "fit_detail", "synthesize"]


def synthesize(
    model: DetailModel,
    take: Markers | Performance,
    config: SynthesisConfig = SynthesisConfig(),
    progress: Progress = SILENT,
    place: int | None = None,
) -> tuple[Synthesizer, Drive, Iterator[SynthesizedFrame]]:
    """A take, or any performance of the same person, with wrinkles and pores; frames come one by one.

    Args:
        place: a frame in which the face is neutral, where the take's markers sit elsewhere than the training's.

    Raises:
        BadInput: markers that do not match the training's.
    """
    drive = drive_of(model, take, place)
    synthesizer = Synthesizer(model, config)
    frames = synthesizer.frames(drive.positions)
    return synthesizer, drive, told(frames, len(drive.positions), progress)


def drive_of(model: DetailModel, take: Markers | Performance, place: int | None = None) -> Drive:
    """Markers, those that others carry, or points that stand in for them."""
    if isinstance(take, Performance):
        return drive_by_performance(model, take)
    if place is not None:
        return place_markers(model, take, place).drive(take)
    return drive_by_markers(model, take)


def told(frames: Iterator[SynthesizedFrame], total: int, progress: Progress) -> Iterator[SynthesizedFrame]:
    """The frames, each told as it comes."""
    for number, frame in enumerate(frames, 1):
        progress.update("synthesis", number, total)
        yield frame
