"""`mien render`: performances, rigs and scans as pictures and films."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..blendshapes.play import textures_of
from ..errors import BadInput
from ..files import existing
from ..io.meshes import read_scan
from ..io.performances import READ, face_kind, read_any_performance
from ..io.rigs import read_any_rig
from ..mesh import Scan
from ..pictures import Look, contact_sheet, label, write_mp4, write_png
from ..pictures.show import (
    Shot,
    distance_from,
    film_frames,
    performance_distance,
    performance_frames,
    rig_look,
    scan_picture,
    shapes_sheet,
    surface_distance,
    turntable,
)
from ..progress import Progress
from ..rig import Performance, Rig
from .bar import bar
from .options import refuse_unused, use_only, verb
from .outputs import check_outputs

FRAMES = 12
"""Frames on a performance's contact sheet where --sheet does not say."""

SHEET_SIZES = 2.5
"""A contact sheet's width, in widths of a single picture."""

LEAST_CELL = 96
"""Pixels a side of a picture on a contact sheet, at least."""

FILM, FRAME, SHEET = "a performance's film", "one frame of a performance", "a performance's contact sheet"
SHAPES, STILL, TURN = "a contact sheet of shapes", "one picture of a rig or scan", "a film of a rig or scan"

USED = {
    FILM: ("shot.still_head", "shot.fps"),
    FRAME: ("shot.still_head", "frame"),
    SHEET: ("shot.still_head", "sheet"),
    SHAPES: ("sheet",),
    STILL: (),
    TURN: ("shot.fps",),
}
"""What comes out -> those of `DEPENDS` that it heeds."""

DEPENDS = ("frame", "sheet", "shot.still_head", "shot.fps")
"""Options that depend on what comes out."""


@verb
def render(
    file: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    frame: int | None = None,
    sheet: int | None = None,
    heat: Path | None = None,
    units: str | None = None,
    textured: Path | None = None,
    shot: Annotated[Shot, Parameter(name="*")] = Shot(),
) -> None:
    """Performances, rigs and scans as pictures (.png) and films (.mp4): shaded, textured or as heat maps.

    A performance becomes a contact sheet, one frame or a film; a rig a contact sheet of its shapes; a scan one picture,
    or a film in which it turns.

    Parameters
    ----------
    file
        A performance or rig (.glb, .usd) or a scan (.obj, .ply, .stl, .glb).
    output
        The picture (.png) or film (.mp4) to write.
    frame
        This frame of a performance alone, counted from 0.
    sheet
        How many frames (evenly spaced) or shapes a contact sheet has.
    heat
        Colour by the distance from this performance, rig or scan: vertex to vertex where the topology is the same, else
        to the nearest point of its surface.
    units
        mm, cm, m, in, or millimetres in one unit as a number; for scans.
    textured
        For a performance: the rig of `mien rig` that it plays on, whose textures then change with its shapes.
    """
    if sheet is not None and sheet < 1:
        raise BadInput(f"--sheet {sheet}: a contact sheet needs one picture at least")
    check_outputs({"a picture or a film": output}, inputs=[file, heat])
    thing = load(file, units)
    other = None if heat is None else load(heat, units)
    way = way_of(thing, other, output, frame)
    use_only(f"for {way}", DEPENDS, *USED[way])
    if other is None:
        refuse_unused("without --heat", "shot.limit")
    if not isinstance(thing, Performance):
        refuse_unused("without a performance", "textured")
    if not any(isinstance(one, Scan) for one in (thing, other)):
        refuse_unused("without a scan", "units")
    with bar() as progress:
        if isinstance(thing, Performance):
            textures = None if textured is None else textures_of(thing, textured)
            show_performance(thing, other, output, frame, sheet, shot, progress, textures)
        elif isinstance(thing, Rig) and way == SHAPES:
            shapes = shapes_sheet(thing, cell(shot, len(thing.names)), sheet, progress=progress)
            write_png(output, shapes)
        else:
            show_still(thing, other, output, shot, progress)
    print(f"wrote {output}")


def way_of(thing: Performance | Rig | Scan, other: object, output: Path, frame: int | None) -> str:
    """What comes out: one of `USED`."""
    film = output.suffix.lower() == ".mp4"
    if isinstance(thing, Performance):
        return FILM if film else SHEET if frame is None else FRAME
    if film:
        return TURN
    return SHAPES if isinstance(thing, Rig) and other is None else STILL


def load(file: Path, units: str | None) -> Performance | Rig | Scan:
    """A `.glb` or USD with animation as Performance, with blend shapes alone as Rig, all else as Scan."""
    kind = face_kind(file) if existing(file).suffix.lower() in READ else Scan
    if kind is Scan:
        return read_scan(file, units)
    return read_any_performance(file) if kind is Performance else read_any_rig(file)


def show_performance(
    thing: Performance,
    other,
    output: Path,
    frame: int | None,
    sheet: int | None,
    shot: Shot,
    progress: Progress,
    textures=None,
) -> None:
    """A film, one frame, or a contact sheet."""
    values = distances(thing, other, shot)
    if output.suffix.lower() == ".mp4":
        frames, rate = film_frames(thing, shot.fps)
        images = performance_frames(
            performance=thing,
            frames=frames,
            shot=shot,
            values=values,
            progress=progress,
            textures=textures,
        )
        write_mp4(output, images, rate)
    elif frame is not None:
        images = performance_frames(
            performance=thing,
            frames=[frame],
            shot=shot,
            values=values,
            progress=progress,
            textures=textures,
        )
        write_png(output, next(images))
    else:
        count = min(sheet or FRAMES, len(thing))
        evenly = np.linspace(0, len(thing) - 1, count)
        frames = evenly.round().astype(int).tolist()
        images = performance_frames(
            thing, frames, cell(shot, count), values=values, progress=progress, textures=textures
        )
        captions = [f"{t / thing.rate:.2f} s" for t in frames]
        marked = list(map(label, images, captions))
        write_png(output, contact_sheet(marked))


def distances(thing: Performance, other, shot: Shot):
    """A frame's number -> one distance a vertex; None where no heat map is asked for."""
    if other is None:
        return None
    if isinstance(other, Performance):
        return performance_distance(thing, other, shot.still_head)
    return distance_from(thing, surface(other).mesh)


def show_still(thing: Rig | Scan, other, output: Path, shot: Shot, progress: Progress) -> None:
    """One picture, or a film in which it turns."""
    scan = surface(thing)
    look = rig_look(scan.mesh) if isinstance(thing, Rig) else Look()
    values = None if other is None else surface_distance(scan.mesh, surface(other).mesh)
    if output.suffix.lower() == ".mp4":
        images = turntable(scan, shot, look, values, progress=progress)
        write_mp4(output, images, shot.fps)
    else:
        write_png(output, scan_picture(scan, shot, look, values))


def surface(thing: Performance | Rig | Scan) -> Scan:
    """What a thing looks like at rest."""
    rig = thing.rig if isinstance(thing, Performance) else thing
    return Scan(rig.neutral, rig.texture) if isinstance(rig, Rig) else rig


def cell(shot: Shot, count: int) -> Shot:
    """The shot of one picture on a contact sheet of `count`: the sheet is two and a half single pictures wide."""
    across = np.ceil(np.sqrt(count))
    size = round(SHEET_SIZES * shot.size / across)
    return replace(shot, size=min(shot.size, max(LEAST_CELL, size)))
