"""`mien FILE`: what a file is and what can be done with it."""

from pathlib import Path
from typing import Any

from ..errors import BadInput
from .kinds import DEPTH_TAKE, LIVE_LINK, MARKERS, PERFORMANCE, RIG, SCAN, Kind, kind_of


def about(path: Path) -> list[str]:
    """Lines for a reader.

    Raises:
        BadInput: of no kind that is known, or damaged.
    """
    kind = kind_of(path)
    if kind is None:
        raise BadInput(f"{path}: of no kind that mien knows; see `mien --help` for what its verbs take")
    lines = [f"{path}: {kind.what}", *content(path, kind)]
    commands = [told for told in kind.commands if not _to_itself(told[0], path)]
    width = max(len(command) for command, _ in commands) + len(str(path))
    for command, brings in commands:
        shown = command.replace("FILE", str(path))
        lines.append(f"  {shown:<{width}}  {brings}")
    return lines


def _to_itself(command: str, path: Path) -> bool:
    """Whether a command converts the file to the format that it has."""
    words = command.split()
    return words[1] == "convert" and Path(words[-1]).suffix == path.suffix.lower()


def content(path: Path, kind: Kind) -> list[str]:
    """What is in it, in one line."""
    thing = _read(path, kind)
    return [] if thing is None else [f"  {thing!r}"]


def _read(path: Path, kind: Kind) -> Any:
    from ..io.livelink import read_live_link
    from ..io.markers import read_markers
    from ..io.meshes import read_scan
    from ..io.performances import read_any_performance
    from ..io.rigs import read_any_rig
    from ..rgbd import read_rgbd
    from ..stream.receive import RECORDING, read_recording, take_of

    if kind is LIVE_LINK:
        recorded = path.suffix.lower() == RECORDING
        take = take_of(read_recording(path)) if recorded else read_live_link(path)
        return take.alone()
    readers = {
        PERFORMANCE.what: read_any_performance,
        RIG.what: read_any_rig,
        SCAN.what: read_scan,
        MARKERS.what: read_markers,
        DEPTH_TAKE.what: read_rgbd,
    }
    reader = readers.get(kind.what)
    return None if reader is None else reader(path)
