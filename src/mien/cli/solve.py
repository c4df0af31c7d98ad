"""`mien solve`: a marker take becomes an animated face."""

from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..files import existing
from ..io.gltf import write_performance
from ..io.markers import MarkerFile, read_marker_file
from ..markers.attachment_file import write_attachment
from ..markers.inputs import read_face, read_placement
from ..markers.pipeline import TakeConfig, solve_take
from ..pictures import write_png
from ..reports.markers import preview, take_report
from ..scans.scan_rig import record_beside
from .bar import bar
from .options import refuse_unused, verb
from .outputs import beside, check_outputs


@verb
def solve(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("perf.glb"),
    rig: Path | None = None,
    units: str | None = None,
    rate: float | None = None,
    markers: str | None = None,
    attach: Path | None = None,
    save_attach: Path | None = None,
    picture: Path | None = None,
    report: Path | None = None,
    config: Annotated[TakeConfig, Parameter(name="*")] = TakeConfig(),
) -> None:
    """Markers (C3D, TRC, CSV) in; an animated face with 52 morph targets and head motion out.

    Parameters
    ----------
    take
        The marker take.
    output
        Where the animated face goes (.glb).
    rig
        Solve on this rig (.glb, ICT-FaceKit's folder, a folder of OBJ or PLY) instead of the bundled face. A rig of
        scans (from `mien register SCANS/`) is solved by its own markers, which its record beside it knows.
    units
        mm, cm, m, in, or millimetres in one unit as a number; needed only where the file's own claim is wrong.
    rate
        Frames a second, where the file does not say.
    markers
        Solve these alone: a pattern with or without the subject (`Actor:*`), several with commas between. By default
        the face is found among a body and props by how its markers stand together.
    attach
        JSON that places every marker by hand; made by --save-attach and edited.
    save_attach
        Write where the markers were found to sit.
    picture
        Write a contact sheet (.png); by default beside the output.
    report
        Write the report (.html); by default beside the output.
    """
    pages = {"a picture": beside(output, picture, ".png"), "a page": beside(output, report, ".html")}
    made = {"an animated face": output, **pages, "where markers sit": save_attach}
    check_outputs(made, inputs=[take, rig, attach])
    of_scans = rig is not None and record_beside(rig).is_file()
    if of_scans:
        refuse_unused("on a rig of scans", "attach", "save_attach", "config")
    file = read_marker_file(existing(take), units, rate, markers)
    if rig is not None and of_scans:
        return solve_on_rig_of_scans(rig, take.name, file, output, picture, report)
    face = read_face(rig)
    by_hand = read_placement(attach, file.markers, face)
    with bar() as progress:
        solved = solve_take(file.markers, face, by_hand, config, progress)
        image = preview(solved, file.markers, progress=progress)
    write_performance(output, solved.performance)
    write_png(picture or output.with_suffix(".png"), image)
    take_report(take.name, solved, file.markers, image, file.warnings).write(report or output.with_suffix(".html"))
    if save_attach:
        write_attachment(save_attach, file.markers.labels, solved.calibration.attachment)
    for line in [*file.warnings, summary(solved)]:
        print(line)


def solve_on_rig_of_scans(
    rig: Path, name: str, file: MarkerFile, output: Path, picture: Path | None, report: Path | None
) -> None:
    """A take on registered scans of the same person with the same markers."""
    from ..io.gltf import read_rig
    from ..reports.scan_solve import scan_preview, scan_solve_report
    from ..scans.reconstruct import solve_on_scans
    from ..scans.scan_rig import read_scan_rig

    scan_rig = read_scan_rig(record_beside(rig), read_rig(rig))
    with bar() as progress:
        solved = solve_on_scans(file.markers, scan_rig, progress=progress)
        image = scan_preview(solved, progress)
    write_performance(output, solved.performance)
    write_png(picture or output.with_suffix(".png"), image)
    scan_solve_report(name, solved, scan_rig, image, file.warnings).write(report or output.with_suffix(".html"))
    performance = solved.performance
    for line in file.warnings:
        print(line)
    print(
        f"{int(performance.tracked.sum())} of {len(performance)} frames solved on {len(scan_rig.expressions)} scans; "
        f"mean residual {np.nanmean(solved.mixed):.2f} mm, with correctives {np.nanmean(solved.residuals):.2f} mm"
    )


def summary(solved) -> str:
    """The line that ends a solve."""
    performance = solved.performance
    return (
        f"{int(performance.tracked.sum())} of {len(performance)} frames solved, mean residual "
        f"{np.nanmean(solved.residuals):.2f} mm, alignment margin {solved.calibration.alignment_margin:.2f}"
    )
