"""`mien solve`: a marker take becomes an animated face."""

from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..files import existing
from ..io.edits_file import write_edited
from ..io.markers import MarkerFile, read_marker_file
from ..markers.attachment_file import write_attachment
from ..markers.inputs import read_face, read_placement, with_neutral
from ..markers.pipeline import TakeConfig, TakeSolve, solve_take
from ..pictures import write_png
from ..progress import Progress
from ..reports.markers import preview, take_report
from ..reports.page import Report
from ..rig import Performance
from ..scans.scan_rig import record_beside
from ..takes.face_cluster import find_face
from ..viewer.moving_page import moving_page
from .bar import bar
from .options import refuse_unused, verb
from .outputs import check_outputs
from .play import tell
from .shared_options import NamedPages, Pages, TakeReading


@verb
def solve(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("perf.glb"),
    rig: Path | None = None,
    markers: str | None = None,
    neutral: str | None = None,
    attach: Path | None = None,
    save_attach: Path | None = None,
    reading: Annotated[TakeReading, Parameter(name="*")] = TakeReading(),
    pages: Annotated[Pages, Parameter(name="*")] = Pages(),
    config: Annotated[TakeConfig, Parameter(name="*")] = TakeConfig(),
) -> None:
    """Markers (C3D, TRC, CSV) in; an animated face with 52 morph targets and head motion out.

    Parameters
    ----------
    take
        The marker take.
    output
        Where the animated face goes (.glb, .usd).
    rig
        Solve on this rig (.glb, .usd, ICT-FaceKit's folder, a folder of OBJ or PLY) instead of the bundled face. A rig
        of scans (from `mien register SCANS/`) is solved by its own markers, which its record beside it knows.
    markers
        Solve the markers whose labels match, such as 'Actor:*' or 'face*,chin'; by default the face is found.
    neutral
        Where the actor's face is at rest: a frame (120) or a time (2.5s); by default it is found.
    attach
        JSON that places every marker by hand; made by --save-attach and edited.
    save_attach
        Write where the markers were found to sit.
    """
    named = pages.named_by(output)
    made = {"an animated face": output, **named.outputs, "where markers sit": save_attach}
    check_outputs(made, inputs=[take, rig, attach])
    of_scans = rig is not None and record_beside(rig).is_file()
    if of_scans:
        refuse_unused("on a rig of scans", "attach", "save_attach", "neutral", "config")
    file = read_marker_file(existing(take), reading.units, reading.rate, markers)
    if rig is not None and of_scans:
        solve_on_rig_of_scans(rig, take.name, file, output, named)
        return
    face = read_face(rig)
    found = find_face(file.markers, config.face)
    worn, by_hand = read_placement(attach, found.markers, face)
    told = config if neutral is None else with_neutral(config, neutral, worn.rate)
    notes = [*file.warnings, *found.lines]
    with bar() as progress:
        solved = solve_take(worn, face, by_hand, told, progress)
        write_solved(output, take.name, solved, named, notes, progress)
    if save_attach:
        on_face = solved.markers.labels
        off_face = tuple(label for label in worn.labels if label not in on_face)
        write_attachment(save_attach, on_face, solved.calibration.attachment, off_face)
    last = summary(solved)
    for line in [*notes, *solved.lines, last]:
        print(line)


def write_solved(
    output: Path, name: str, solved: TakeSolve, pages: NamedPages, notes: list[str], progress: Progress
) -> None:
    """The animated face, its picture, and the report in which it moves."""
    image = preview(solved, progress=progress)
    page = take_report(
        name=name,
        solved=solved,
        picture=image,
        notes=notes,
        moving=moving_page(solved.performance, output.name),
    )
    write_results(output, solved.performance, pages, image, page)


def solve_on_rig_of_scans(rig: Path, name: str, file: MarkerFile, output: Path, pages: NamedPages) -> None:
    """A take on registered scans of the same person with the same markers."""
    from ..io.rigs import read_any_rig
    from ..reports.scan_solve import scan_preview, scan_solve_report
    from ..scans.reconstruct import solve_on_scans
    from ..scans.scan_rig import read_scan_rig

    scan_rig = read_scan_rig(record_beside(rig), read_any_rig(rig))
    with bar() as progress:
        solved = solve_on_scans(file.markers, scan_rig, progress=progress)
        image = scan_preview(solved, progress)
    page = scan_solve_report(name, solved, scan_rig, image, file.warnings)
    write_results(output, solved.performance, pages, image, page)
    performance = solved.performance
    for line in file.warnings:
        print(line)
    print(
        f"{int(performance.tracked.sum())} of {len(performance)} frames solved on {len(scan_rig.expressions)} scans; "
        f"mean residual {np.nanmean(solved.mixed):.2f} mm, with correctives {np.nanmean(solved.residuals):.2f} mm"
    )


def write_results(output: Path, performance: Performance, pages: NamedPages, image: np.ndarray, page: Report) -> None:
    """The animated face and the pages beside it, all named."""
    write_edited(output, performance, tell)
    write_png(pages.picture, image)
    page.write(pages.report)


def summary(solved) -> str:
    """The line that ends a solve."""
    performance = solved.performance
    frames = f"{int(performance.tracked.sum())} of {len(performance)} frames solved"
    known = str(solved.left_out) or f"mean residual {np.nanmean(solved.residuals):.2f} mm"
    return f"{frames}, {known}, alignment margin {solved.calibration.alignment_margin:.2f}"
