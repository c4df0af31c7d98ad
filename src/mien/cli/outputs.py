"""Where results go is checked before the work that makes them."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import BadInput
from ..extras import require
from ..files import writable, writable_folder
from ..io import usd
from ..io.performances import WRITTEN as FACES

KINDS = {
    "an animated face": FACES,
    "a rig": FACES,
    "a textured rig": (".glb",),
    "a face": FACES,
    "a face with all 52 shapes": FACES,
    "a picture": (".png",),
    "a contact sheet": (".png",),
    "a picture or a film": (".png", ".mp4"),
    "a page": (".html",),
    "a merged scan": (".ply", ".obj"),
    "a scan": (".ply", ".obj", ".exr"),
    "a selection": (".json",),
    "where markers sit": (".json",),
    "a marker take": (".c3d",),
    "Live Link weights": (".csv",),
    "a mesh": (".obj", ".ply"),
    "a calibration": (".json",),
}
"""What a verb may write -> the suffixes it may have."""

FOLDER = "a folder"
ANY = "a file"
"""A file whose suffix the verb itself looks at."""


def check_outputs(outputs: Mapping[str, Path | None], inputs: Iterable[Path | str | None] = ()) -> None:
    """Refuse, before the work, outputs that could not be written, or would overwrite an input or each other.

    Args:
        outputs: one of `KINDS`, `FOLDER` or `ANY` -> its path; None where it is not asked for.
        inputs: files and folders that are read; words such as `live`, and None, are no files.

    Raises:
        BadInput: what is wrong with the first that is wrong.
    """
    read = _files(inputs)
    places = set()
    for kind, path in outputs.items():
        if path is None:
            continue
        _check_one(kind, path)
        if path.exists() and any(map(path.samefile, read)):
            raise BadInput(f"{path}: is read and would be overwritten; give the output another name")
        place = path.absolute()
        if place in places:
            raise BadInput(f"{path}: two outputs have this name; give each its own")
        places.add(place)


def _files(inputs: Iterable[Path | str | None]) -> list[Path]:
    """Those inputs that are there as files or folders."""
    paths = [Path(given) for given in inputs if given is not None]
    return [path for path in paths if path.exists()]


def beside(output: Path, other: Path | None, suffix: str) -> Path:
    """`other`, or by default the output's name with another suffix."""
    return output.with_suffix(suffix) if other is None else other


def _check_one(kind: str, path: Path) -> None:
    if kind == FOLDER:
        writable_folder(path)
        return
    if path.is_dir():
        raise BadInput(f"{path}: is a folder; name a file")
    if kind != ANY:
        _check_suffix(kind, path)
    if path.suffix.lower() in usd.SUFFIXES:
        require("pxr", "usd")
    writable(path)


def _check_suffix(kind: str, path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix in KINDS[kind]:
        return
    written = " or ".join(KINDS[kind])
    raise BadInput(f"{path}: {kind} is written as {written}; name it so")
