"""Captures read one after the other: finished ones are kept on disk, and one that cannot be used is left out."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..errors import BadInput
from ..progress import SILENT, Progress
from ..step_cache import code_version, fingerprint
from .captures import Capture, read_capture
from .map_file import read_map, write_map
from .scan.pipeline import FusionConfig


def read_captures(
    paths: Sequence[Path],
    neutral: str,
    work: Path,
    depth_scale: float | None = None,
    unit: str | None = None,
    config: FusionConfig = FusionConfig(),
    progress: Progress = SILENT,
) -> tuple[list[Capture], list[str]]:
    """The captures that can be read, and a line for each that cannot.

    Raises:
        BadInput: the neutral one cannot.
    """
    read, lost = [], []
    for done, path in enumerate(paths):
        progress.update("captures", done, len(paths))
        try:
            read.append(kept(path, work, depth_scale, unit, config))
        except BadInput as error:
            if path.stem == neutral:
                raise
            lost.append(f"left out: {error}")
    progress.update("captures", len(paths), len(paths))
    return read, lost


def kept(path: Path, work: Path, depth_scale: float | None, unit: str | None, config: FusionConfig) -> Capture:
    """One capture, from `work` if these files were read by this code before."""
    name = fingerprint((code_version(), stamps(path), depth_scale, unit, config))
    file = work / f"{path.stem}-{name}.exr"
    if file.is_file():
        map_ = read_map(file).named(path.stem)
        return Capture(map_, "read before")
    capture = read_capture(path, depth_scale, unit, config)
    capture = replace(capture, map=capture.map.named(path.stem))
    work.mkdir(parents=True, exist_ok=True)
    write_map(file, capture.map)
    return capture


def stamps(path: Path) -> list[tuple[str, int, int]]:
    """Name, size and time of every file of a capture."""
    files = sorted(path.rglob("*")) if path.is_dir() else [path]
    return [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files if file.is_file()]
