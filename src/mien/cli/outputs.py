"""Where results go is checked before the work that makes them."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import BadInput
from ..files import writable, writable_folder

KINDS = {
    "an animated face": (".glb",),
    "a rig": (".glb",),
    "a face": (".glb",),
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
    asked = {kind: path for kind, path in outputs.items() if path is not None}
    read = [Path(path) for path in inputs if path is not None and Path(path).exists()]
    for kind, path in asked.items():
        _check_one(kind, path)
        if path.exists() and any(path.samefile(source) for source in read):
            raise BadInput(f"{path}: is read and would be overwritten; give the output another name")
    places = [path.absolute() for path in asked.values()]
    for path in asked.values():
        if places.count(path.absolute()) > 1:
            raise BadInput(f"{path}: two outputs have this name; give each its own")


def beside(output: Path, other: Path | None, suffix: str) -> Path:
    """`other`, or by default the output's name with another suffix."""
    return output.with_suffix(suffix) if other is None else other


def _check_one(kind: str, path: Path) -> None:
    if kind == FOLDER:
        writable_folder(path)
        return
    if path.is_dir():
        raise BadInput(f"{path}: is a folder; name a file")
    if kind != ANY and path.suffix.lower() not in KINDS[kind]:
        raise BadInput(f"{path}: {kind} is written as {' or '.join(KINDS[kind])}; name it so")
    writable(path)
