"""`mien render`: performances, rigs and scans as pictures and films."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..errors import BadInput
from ..files import existing
from ..io.gltf import read_performance, read_rig
from ..io.gltf.glb import open_glb
from ..io.meshes import read_scan
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
from .options import verb

SHEET = 12
"""Frames on a performance's contact sheet where --sheet does not say."""


@verb
def render(
    file: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    frame: int | None = None,
    sheet: int | None = None,
    heat: Path | None = None,
    units: str | None = None,
    shot: Annotated[Shot, Parameter(name="*")] = Shot(),
) -> None:
    """Performances, rigs and scans as pictures (.png) and films (.mp4): shaded, textured or as heat maps.

    A performance becomes a contact sheet, one frame or a film; a rig a contact sheet of its shapes; a scan one picture,
    or a film in which it turns.

    Parameters
    ----------
    file
        A performance or rig (.glb) or a scan (.obj, .ply, .stl, .glb).
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
    """
    if sheet is not None and sheet < 1:
        raise BadInput(f"--sheet {sheet}: a contact sheet needs one picture at least")
    if output.suffix.lower() not in (".png", ".mp4"):
        raise BadInput(f"{output}: give a picture (.png) or a film (.mp4)")
    thing, other = load(file, units), None if heat is None else load(heat, units)
    with bar() as progress:
        if isinstance(thing, Performance):
            performance(thing, other, output, frame, sheet, shot, progress)
        elif frame is not None:
            raise BadInput(f"{file}: has no frames; leave --frame out")
        elif isinstance(thing, Rig) and other is None and output.suffix.lower() == ".png":
            write_png(output, shapes_sheet(thing, cell(shot, len(thing.names)), sheet, progress=progress))
        else:
            still(thing, other, output, shot, progress)


def load(file: Path, units: str | None) -> Performance | Rig | Scan:
    """A `.glb` with animation as Performance, with morph targets alone as Rig, all else as Scan."""
    if existing(file).suffix.lower() == ".glb":
        content = open_glb(file).json
        parts = [part for mesh in content.get("meshes", []) for part in mesh.get("primitives", [])]
        if any("targets" in part for part in parts):
            return read_performance(file) if content.get("animations") else read_rig(file)
    return read_scan(file, units)


def performance(thing: Performance, other, output: Path, frame, sheet, shot: Shot, progress: Progress) -> None:
    """A film, one frame, or a contact sheet."""
    if other is None:
        values = None
    elif isinstance(other, Performance):
        values = performance_distance(thing, other, shot.still_head)
    else:
        values = distance_from(thing, surface(other).mesh)
    if output.suffix.lower() == ".mp4":
        frames, rate = film_frames(thing, shot.fps)
        write_mp4(output, performance_frames(thing, frames, shot, values=values, progress=progress), rate)
    elif frame is not None:
        write_png(output, next(performance_frames(thing, [frame], shot, values=values, progress=progress)))
    else:
        count = min(sheet or SHEET, len(thing))
        frames = np.linspace(0, len(thing) - 1, count).round().astype(int).tolist()
        images = performance_frames(thing, frames, cell(shot, count), values=values, progress=progress)
        marked = [label(image, f"{t / thing.rate:.2f} s") for t, image in zip(frames, images, strict=True)]
        write_png(output, contact_sheet(marked))


def still(thing: Rig | Scan, other, output: Path, shot: Shot, progress: Progress) -> None:
    """One picture, or a film in which it turns."""
    scan = surface(thing)
    look = rig_look(scan.mesh) if isinstance(thing, Rig) else Look()
    values = None if other is None else surface_distance(scan.mesh, surface(other).mesh)
    if output.suffix.lower() == ".mp4":
        write_mp4(output, turntable(scan, shot, look, values, progress=progress), shot.fps)
    else:
        write_png(output, scan_picture(scan, shot, look, values))


def surface(thing: Performance | Rig | Scan) -> Scan:
    """What a thing looks like at rest."""
    rig = thing.rig if isinstance(thing, Performance) else thing
    return Scan(rig.neutral, rig.texture) if isinstance(rig, Rig) else rig


def cell(shot: Shot, count: int) -> Shot:
    """The shot of one picture on a contact sheet of `count`: the sheet is two and a half single pictures wide."""
    return replace(shot, size=min(shot.size, max(96, round(2.5 * shot.size / np.ceil(np.sqrt(count))))))
