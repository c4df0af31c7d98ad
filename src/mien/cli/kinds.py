"""What a file is, and what can be done with it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import BadInput

FACES = (".glb", ".gltf", ".vrm", ".usd", ".usda", ".usdc", ".usdz")
SCANS = (".obj", ".ply", ".stl")
TABLES = (".csv", ".tsv", ".txt")
FILMS = (".mp4", ".mov", ".avi", ".m4v", ".mkv", ".webm")
PICTURES = (".png", ".jpg", ".jpeg")
DEPTH_TAKES = (".r3d", ".bag")


@dataclass(frozen=True)
class Kind:
    """A kind of file."""

    what: str
    commands: tuple[tuple[str, str], ...]
    """What can be done with it: a command with FILE for the file, and what it brings."""

    @property
    def verbs(self) -> set[str]:
        """Verbs that take it."""
        return {command.split()[1] for command, _ in self.commands}


PERFORMANCE = Kind(
    "an animated face",
    (
        ("mien view FILE", "see it move in the browser"),
        ("mien render FILE -o film.mp4", "a film"),
        ("mien convert FILE -o perf.usdz", "to USD, Alembic, Live Link Face .csv, virtual markers"),
        ("mien retarget FILE --to avatar.vrm -o out.glb", "onto another rig"),
        ("mien stream FILE --vmc 127.0.0.1:39539", "to an avatar program, or with --livelink to Unreal"),
        ("mien detail synth FILE --maps maps/ -o detail.mp4", "with wrinkles and pores"),
    ),
)
RIG = Kind(
    "a rig",
    (
        ("mien view FILE", "move its shapes in the browser"),
        ("mien solve take.c3d --rig FILE -o perf.glb", "play markers on it"),
        ("mien track clip.mp4 --rig FILE -o perf.glb", "play a video on it"),
        ("mien retarget perf.glb --to FILE -o out.glb", "play a performance on it"),
        ("mien render FILE -o shapes.png", "a sheet of its shapes"),
        ("mien convert FILE -o rig.usdc", "to USD"),
        ("mien personalize take/ -o rig.glb", "make one of a person"),
        ("mien stream clip.mp4 --rig FILE --vmc 127.0.0.1:39539", "track on it, and send"),
    ),
)
SCAN = Kind(
    "a scan",
    (
        ("mien register FILE -o face.glb", "a rig with 52 shapes"),
        ("mien view FILE", "look at it in the browser"),
        ("mien render FILE -o scan.png", "a picture"),
        ("mien convert FILE -o scan.ply", "to another format"),
    ),
)
MARKERS = Kind(
    "a marker take",
    (
        ("mien solve FILE -o perf.glb", "an animated face"),
        ("mien select FILE -o selection.json", "which frames to scan"),
        ("mien view FILE", "look at it in the browser"),
        ("mien convert FILE -o take.c3d", "to C3D"),
        ("mien register scans/ --markers FILE --selection selection.json -o rig.glb", "a rig of scans"),
        ("mien detail synth FILE --maps maps/ -o frames/", "with wrinkles and pores"),
    ),
)
LIVE_LINK = Kind(
    "a Live Link Face recording",
    (
        ("mien convert FILE -o perf.glb", "play it on the bundled face"),
        ("mien convert FILE --rig avatar.vrm -o perf.glb", "play it on a rig or an avatar"),
        ("mien stream FILE --vmc 127.0.0.1:39539", "send it to an avatar program"),
    ),
)
VIDEO = Kind(
    "a video",
    (
        ("mien track FILE -o perf.glb", "an animated face"),
        ("mien personalize FILE -o rig.glb", "the person's rig first"),
        ("mien stream FILE --vmc 127.0.0.1:39539", "track it, and send"),
        ("mien view perf.glb FILE", "look at it beside a performance"),
    ),
)
DEPTH_TAKE = Kind(
    "an RGB-D take",
    (
        ("mien personalize FILE -o rig.glb", "the person's rig, from calm frames"),
        ("mien track FILE --rig rig.glb -o perf.glb", "an animated face"),
        ("mien scan FILE -o scan.ply", "a held expression to one scan"),
        ("mien stream FILE --rig rig.glb --vmc 127.0.0.1:39539", "track it, and send"),
        ("mien rig captures/ -o me.glb", "a rig of several such takes"),
        ("mien view perf.glb FILE", "its pictures beside the face that was tracked in it"),
    ),
)
SCANS_FOLDER = Kind(
    "a folder of meshes",
    (
        ("mien convert FILE -o rig.glb", "a rig, where one is named neutral and all share their vertices"),
        ("mien register FILE --markers take.c3d --selection selection.json -o rig.glb", "a rig of scans of a take"),
        ("mien rig FILE -o me.glb", "a rig of textured meshes, one an expression"),
        ("mien solve take.c3d --rig FILE -o perf.glb", "play markers on it, where it is a rig"),
        ("mien retarget perf.glb --to FILE -o out.glb", "play a performance on it, where it is a rig"),
        ("mien view FILE", "look at it"),
    ),
)
LIGHT_TAKE = Kind("a take of active light", (("mien decode FILE -o scan.exr", "a detailed scan"),))
LIGHT_SCAN = Kind(
    "a scan of active light", (("mien convert FILE -o scan.ply", "a mesh, to register, to view, to render"),)
)
MAP = Kind(
    "a map of a surface",
    (
        ("mien rig FOLDER -o me.glb", "a rig of the folder of maps that it lies in"),
        ("mien view FILE", "move its landmarks, pin points, paint out what must not count"),
    ),
)


def kind_of(path: Path) -> Kind | None:
    """What a file is, by its name and as little of its content as tells; None where nobody knows."""
    suffix = path.suffix.lower()
    if path.is_dir():
        return _folder(path)
    if suffix in FACES:
        return _face(path)
    if suffix == ".c3d" or suffix == ".trc":
        return MARKERS
    if suffix in TABLES:
        return LIVE_LINK if is_live_link(path) else MARKERS
    if suffix == ".exr":
        return LIGHT_SCAN if is_light_scan(path) else MAP
    simple = {SCANS: SCAN, FILMS: VIDEO, DEPTH_TAKES: DEPTH_TAKE, (".gesichter",): LIVE_LINK}
    return next((kind for suffixes, kind in simple.items() if suffix in suffixes), None)


def is_live_link(path: Path) -> bool:
    """Whether a table is a Live Link Face file."""
    from ..io.live_link_table import find_columns, read_table

    try:
        header, _ = read_table(path)
        find_columns(path, header)
    except (BadInput, OSError):
        return False
    return True


def is_light_scan(path: Path) -> bool:
    """Whether an EXR is what `mien decode` writes."""
    from ..light.disk.light_scan import read_light_scan

    try:
        read_light_scan(path)
    except BadInput:
        return False
    return True


def hint(verb: str, words: Sequence[str]) -> str:
    """What a file that a verb could not use is good for instead; empty where the verb takes such files."""
    paths = [Path(word) for word in words if not word.startswith("-")]
    there = next((path for path in paths if path.exists()), None)
    kind = None if there is None else _known(there)
    if kind is None or verb in kind.verbs:
        return ""
    command, brings = kind.commands[0]
    shown = command.replace("FILE", str(there))
    return f"; {there} is {kind.what}: `{shown}` ({brings})"


def _known(path: Path) -> Kind | None:
    try:
        return kind_of(path)
    except (BadInput, OSError):
        return None


def _face(path: Path) -> Kind:
    from ..io.performances import face_kind
    from ..mesh import Scan
    from ..rig import Performance

    return {Scan: SCAN, Performance: PERFORMANCE}.get(face_kind(path), RIG)


def _folder(path: Path) -> Kind | None:
    names = {child.name.lower() for child in path.iterdir()}
    suffixes = [Path(name).suffix for name in names]
    if "color" in names or "depth" in names:
        return DEPTH_TAKE
    if "calibration.json" in names or "patterns.json" in names or "take.json" in names:
        return LIGHT_TAKE
    if any(suffix in SCANS for suffix in suffixes):
        return SCANS_FOLDER
    if any(suffix in PICTURES for suffix in suffixes):
        return VIDEO
    return None
