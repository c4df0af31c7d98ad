"""`mien select`: the fewest frames of a take to scan."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..files import existing
from ..io.markers import read_marker_file
from ..scans.select.select_frames import SelectConfig, Selection
from ..scans.select.take_selection import SelectTakeConfig, TakeSelection, select_take, write_selection
from .bar import bar
from .options import refuse_unused, verb
from .outputs import beside, check_outputs
from .shared_options import TakeReading


@verb
def select(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("selection.json"),
    tolerance: float = SelectConfig.tolerance,
    strongest: float = SelectConfig.strongest,
    max_frames: int = SelectConfig.max_frames,
    markers: str | None = None,
    spare_markers: bool = False,
    video: Path | None = None,
    video_offset: float = 0.0,
    sheet: Path | None = None,
    reading: Annotated[TakeReading, Parameter(name="*")] = TakeReading(),
) -> None:
    """The expressions to ask the actor for: the fewest frames from which all others can be mixed.

    Parameters
    ----------
    take
        The marker take (C3D, TRC, CSV).
    output
        Where the list of frames goes (.json).
    tolerance
        Mean marker error to reach, as a part of the diagonal of the box of all markers.
    strongest
        ... and of the strongest tenth of the frames, as a part of how far they are from the take's mean face, so that
        calm frames do not hide them. inf: the mean alone.
    max_frames
        Stop at so many frames even if the tolerance is not met.
    markers
        Use the markers whose labels match, such as 'Actor:*' or 'face*,chin'; by default all.
    spare_markers
        Also find out which markers could be spared.
    video
        Film of the same performance: makes a contact sheet of the chosen frames.
    video_offset
        Seconds into the film at which the take begins.
    sheet
        Where the contact sheet goes (.png); by default beside the output.
    """
    sheet = beside(output, sheet, ".png") if video is not None else None
    check_outputs({"a selection": output, "a contact sheet": sheet}, inputs=[take, video])
    if video is None:
        refuse_unused("without --video", "video_offset", "sheet")
    else:
        first_still(video)
    file = read_marker_file(existing(take), reading.units, reading.rate, markers)
    stop = SelectConfig(tolerance, strongest, max_frames)
    config = replace(SelectTakeConfig(), select=stop)
    with bar() as progress:
        found = select_take(file.markers, config, progress)
        study = studied(found, progress) if spare_markers else None
    if video is not None and sheet is not None:
        draw_sheet(sheet, video, video_offset, found, file.markers.rate)
    write_selection(output, take.name, found, study)
    for line in [*file.warnings, *summary(found, study)]:
        print(line)


def first_still(video: Path):
    """See, before long work, that a film is one.

    Raises:
        BadInput: it is none.
    """
    from ..rgbd.image_sequence import read_stills

    return read_stills(video, [0.0])[0]


def studied(found: TakeSelection, progress):
    """The marker study on what the selection saw."""
    from ..scans.select.marker_reduction import select_markers

    return select_markers(found.positions, found.bases, progress=progress)


def draw_sheet(path: Path, video: Path, offset: float, found: TakeSelection, rate: float) -> None:
    """A contact sheet of the film at the chosen frames, in the order of choice."""
    from ..pictures import contact_sheet, write_png
    from ..rgbd.image_sequence import read_stills

    frames = found.selection.frames.tolist()
    times = [offset + frame / rate for frame in frames]
    stills = read_stills(video, times)
    captions = [f"{place + 1}: frame {frame}" for place, frame in enumerate(frames)]
    write_png(path, contact_sheet(stills, captions))


def summary(found: TakeSelection, study) -> list[str]:
    """The lines that end a selection."""
    selection = found.selection
    reached = "reached" if selection.reached else "NOT reached; allow more with --max-frames"
    numbers = ", ".join(map(str, selection.frames.tolist()))
    lines = [
        *curve(selection),
        f"{len(selection.frames)} frames to scan: {numbers}",
        f"mean marker error {selection.errors[-1]:.3f} mm, {100 * selection.relative[-1]:.3f} % of the diagonal "
        f"{selection.diagonal:.0f} mm (tolerance {100 * selection.tolerance:g} %); strongest tenth "
        f"{selection.strongest[-1]:.0%} (tolerance {selection.strongest_tolerance:.0%}): {reached}",
    ]
    if found.left_out:
        lines.append(f"seen too seldom and left out: {', '.join(found.left_out)}")
    if study is not None:
        lines.append(spare(study))
    return lines


def spare(study) -> str:
    """How well half of the markers would do."""
    removed = min(len(study.removed), study.markers // 2)
    half = study.markers - removed
    return (
        f"with the best {half} of {study.markers} markers the error over all of them is "
        f"{study.errors[removed]:.3f} mm instead of {study.errors[0]:.3f} mm"
    )


def curve(selection: Selection) -> list[str]:
    """How the errors fall with the number of frames, and where the paper's stop alone would be."""
    columns = zip(selection.errors, selection.relative, selection.strongest, strict=True)
    rows = [
        f"{count:6d} {error:9.3f} {100 * relative:12.3f} {100 * strong:18.1f}"
        for count, (error, relative, strong) in enumerate(columns, 1)
    ]
    met = selection.relative < selection.tolerance
    enough = np.argmax(met) + 1
    alone = f"by the mean alone {enough} would do" if met.any() else "the mean alone is not met either"
    return ["frames  mean, mm  % of diagonal  strongest tenth, %", *rows, alone]
