"""Files of all kinds, opened for the page."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..blendshapes.build.masks import TexturedRig
from ..blendshapes.build.rig_files import read_textured_rig
from ..blendshapes.cylinder_map import mesh_of_map
from ..blendshapes.map_file import read_map
from ..blendshapes.play import textured_for
from ..clip import Markers
from ..errors import BadInput
from ..files import existing
from ..io.edits_file import read_captured
from ..io.markers import READERS, read_marker_file
from ..io.meshes import read_scan
from ..io.performances import READ, face_kind
from ..io.rigs import read_any_rig
from ..mesh import Scan
from ..rig import Performance, Rig
from .studio_scene import Film, Shown
from .take_film import PLAYED, RECORDED, film_of, has_film
from .worst_regions import is_record, read_regions, scans_to_mend

SCANS = (".ply", ".obj", ".stl")
MAP = ".exr"
"""A capture laid out, as `mien scan -o smile.exr` writes it."""
MAP_STEP = 2
"""Every so many pixels of a map is a vertex of what is shown."""


def gather(
    files: Sequence[Path], units: str | None = None, textured: Path | None = None
) -> tuple[list[Shown], list[Film]]:
    """Everything that is to be shown, by its suffix; performances with the textures of the rig `textured`.

    Beside a registration's record (`worst_regions`) a folder stands for the two of its scans that most need mending.

    Raises:
        BadInput: missing, of no kind that is known, or what its reader raises.
    """
    record = next((file for file in files if is_record(file)), None)
    regions = {} if record is None else read_regions(record)
    shown, films = [], []
    for file in _named(files, record):
        suffix = file.suffix.lower()
        if has_film(file):
            films.append(film_of(file))
        elif suffix in READERS:
            shown.append(Shown(file.name, open_take(file, units), file, units))
        else:
            face, worst = open_face(file, units), regions.get(file.stem, ())
            shown.append(Shown(file.name, face, file, units, textures_for(face, file, textured), worst))
    return shown, films


def _named(files: Sequence[Path], record: Path | None) -> list[Path]:
    """The files to open: beside a registration's record a folder stands for its two scans that most need mending."""
    found = []
    for file in map(existing, files):
        if record is not None and file.is_dir() and not has_film(file):
            found += scans_to_mend(record, file, SCANS)
        elif file != record:
            found.append(file)
    return found


def textures_for(face: Performance | Rig | Scan, file: Path, textured: Path | None) -> TexturedRig | None:
    """What changes with a face's shapes: a rig's own textures, a performance's where their rig is named.

    Raises:
        BadInput: that rig has none, or is another one.
    """
    if isinstance(face, Rig):
        return read_textured_rig(file)
    if isinstance(face, Performance) and textured is not None:
        return textured_for(face, textured)
    return None


def reopened(shown: Shown) -> Shown:
    """The same thing as its file has it now.

    Raises:
        BadInput: what its reader raises.
    """
    if shown.path is None:
        return shown
    if isinstance(shown.thing, Markers):
        return replace(shown, thing=open_take(shown.path, shown.units))
    thing = open_face(shown.path, shown.units)
    return replace(shown, thing=thing, textured=textures_for(thing, shown.path, None) or shown.textured)


def open_take(file: Path, units: str | None = None) -> Markers:
    """Markers as their file has them, with none of what was corrected. Errors as `read_marker_file`."""
    return read_marker_file(file, units, as_filed=True).markers


def open_face(file: Path, units: str | None = None) -> Performance | Rig | Scan:
    """A `.glb` or USD with animation as Performance, with morph targets or a folder as Rig, else a mesh or map as Scan.

    Raises:
        BadInput: of no kind that is known, or what its reader raises.
    """
    suffix = file.suffix.lower()
    if file.is_dir():
        return read_any_rig(file, units)
    if suffix == MAP:
        return mesh_of_map(read_map(file), MAP_STEP)
    kind = face_kind(file) if suffix in READ else None
    if kind is Performance:
        return read_captured(file)
    if kind is Rig:
        return read_any_rig(file)
    if kind is Scan or suffix in SCANS:
        return read_scan(file, units)
    known = ", ".join((*READ, *SCANS, MAP, *READERS, *PLAYED, *RECORDED))
    raise BadInput(f"{file}: is nothing that can be shown; give one of {known}")
