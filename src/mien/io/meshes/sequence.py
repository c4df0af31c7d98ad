"""Performances as one mesh file a frame."""

from pathlib import Path

from ...errors import BadInput
from ...progress import SILENT, Progress
from ...rig import Performance
from . import WRITERS


def write_sequence(
    folder: str | Path, performance: Performance, suffix: str = ".ply", world: bool = True, progress: Progress = SILENT
) -> list[Path]:
    """Write `frame_000000.ply`, ... into `folder`, millimetres; made if it is not there, files of those names replaced.

    `suffix` is .ply or .obj. With `world` the head moves as in the take; without, the face stays in face space. One
    frame at a time is in memory. The rig's texture is not repeated: it belongs to the rig's own file.

    Raises:
        BadInput: another suffix, or `folder` is a file or its parent does not exist.
    """
    folder = Path(folder)
    if suffix not in WRITERS:
        raise BadInput(f"{folder}: cannot write frames as {suffix}; use {' or '.join(WRITERS)}")
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"{folder}: is a file, and a sequence needs a folder; give another name")
    if not folder.parent.is_dir():
        raise BadInput(f"{folder}: the folder {folder.parent} does not exist; create it first")
    folder.mkdir(exist_ok=True)
    written = []
    for t, mesh in enumerate(performance.meshes(world=world)):
        written.append(folder / f"frame_{t:06d}{suffix}")
        WRITERS[suffix](written[-1], mesh, None)
        progress.update("write frames", t + 1, len(performance))
    return written
