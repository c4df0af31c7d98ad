"""`mien convert`: from one file format to another."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..errors import BadInput
from ..extras import require
from ..files import existing
from ..io.alembic import SUFFIX, write_alembic
from ..io.edits_file import read_edited
from ..io.livelink import LiveLinkTake, read_live_link, write_live_link
from ..io.markers import READERS as MARKERS
from ..io.markers import read_marker_file, write_c3d
from ..io.meshes import SUFFIXES as SCANS
from ..io.meshes import WRITERS as MESHES
from ..io.meshes import read_scan, write_mesh
from ..io.meshes.sequence import write_sequence
from ..io.name_map import read_name_map
from ..io.performances import READ as FACES
from ..io.performances import WRITTEN, write_any_performance
from ..io.rigs import read_any_rig, write_any_rig
from ..markers.attachment_file import labels_on_face, read_attachment
from ..rig.virtual_markers import sample_markers, virtual_markers
from ..stream.receive import RECORDING, read_recording, take_of
from .bar import bar
from .options import refuse_unused, use_only, verb
from .outputs import ANY, FOLDER, check_outputs
from .play import play_on, tell


@dataclass(frozen=True)
class ConvertOptions:
    """What depends on which way a conversion goes."""

    units: str | None = None
    """Unit of a marker take, a scan or a folder of shapes: mm, cm, m, in or millimetres in one unit."""
    rate: float | None = None
    """Frames a second of a marker take or a Live Link Face file that does not say, or says it wrongly."""
    markers: str | None = None
    """Of a marker take these alone: a pattern with or without the subject (`Actor:*`), several with commas between."""
    rig: Path | None = None
    """The face that plays a Live Link Face file; by default the bundled one. What else its file holds stays."""
    map: Path | None = None
    """Pairs of shape names by hand, where spelling does not tell: JSON {"theirs": "jawOpen"}, or CSV."""
    frames_as: Literal["ply", "obj"] = "ply"
    """ply or obj, for a mesh a frame."""
    still_head: bool = False
    """Leave head motion out of a mesh a frame, or of a point cache."""
    attachment: Path | None = None
    """Of virtual markers: where they sit (.json, as `mien solve --save-attach` writes it); without it, all over."""
    count: int = 60
    """Of virtual markers: how many, without --attachment."""


@verb
def convert(
    source: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    options: Annotated[ConvertOptions, Parameter(name="*")] = ConvertOptions(),
) -> None:
    """Convert a file: marker takes, performances, rigs, scans.

    Marker take (.c3d .trc .csv) -> .c3d. Performance or rig (.glb .gltf .vrm .usd .usda .usdc .usdz) -> .glb or USD.
    Performance -> Live Link Face .csv, Alembic .abc, a folder with a mesh a frame, virtual markers as .c3d. Live Link
    Face .csv or packets (.gesichter) -> .glb or USD. Folder of shapes -> .glb or USD. Scan (.obj .ply .stl .glb, or
    .exr of active light) -> .obj or .ply. Films are made by `mien render`.

    Parameters
    ----------
    source:
        What to read.
    output:
        What to write; its suffix says what it becomes, no suffix means a folder.
    """
    source = existing(source)
    end = output.suffix.lower()
    check_outputs({ANY if end else FOLDER: output}, inputs=[source, options.rig])
    kind = FOLDER if source.is_dir() else source.suffix.lower()
    way = way_from(source, kind, end)
    used = [f"options.{name}" for name in way.options]
    use_only(f"from {kind} to {end or FOLDER}", OPTIONS, *used)
    way.go(source, output, options)
    print(f"wrote {output}")


def _markers(source: Path, output: Path, options: ConvertOptions) -> None:
    take = read_marker_file(source, options.units, options.rate, options.markers, whole=True)
    for warning in take.warnings:
        tell(warning)
    write_c3d(output, take.markers, up="+Y" if take.up_source == "file" else None)


def _live_link(source: Path, output: Path, options: ConvertOptions) -> None:
    take = read_live_link(source, options.rate)
    for line in take.notes:
        tell(line)
    _play(take, output, options)


def _packets(source: Path, output: Path, options: ConvertOptions) -> None:
    packets = read_recording(source)
    _play(take_of(packets), output, options)


def _play(take: LiveLinkTake, output: Path, options: ConvertOptions) -> None:
    """A take of weights on the rig that is named, else on the bundled face."""
    given = {} if options.map is None else read_name_map(options.map)
    if options.rig is not None:
        play_on(take.alone(), options.rig, output, given, correctives=False)
        return
    from ..faces.bundled import load_face

    write_any_performance(output, take.to_performance(load_face().rig, given))


def _to_live_link(source: Path, output: Path, options: ConvertOptions) -> None:
    write_live_link(output, read_edited(source, tell))


def _to_sequence(source: Path, output: Path, options: ConvertOptions) -> None:
    performance = read_edited(source, tell)
    with bar() as progress:
        write_sequence(output, performance, f".{options.frames_as}", not options.still_head, progress)


def _to_alembic(source: Path, output: Path, options: ConvertOptions) -> None:
    require("alembic3d", "alembic")
    performance = read_edited(source, tell)
    with bar() as progress:
        write_alembic(output, performance, not options.still_head, progress)


def _to_markers(source: Path, output: Path, options: ConvertOptions) -> None:
    performance = read_edited(source, tell)
    rig = performance.rig
    if options.attachment is None:
        try:
            attachment = sample_markers(rig, options.count)
        except ValueError as error:
            raise BadInput(f"--{error}") from error
        labels = tuple(f"v{number + 1:03d}" for number in range(options.count))
    else:
        refuse_unused("with --attachment", "options.count")
        labels = labels_on_face(options.attachment)
        attachment = read_attachment(options.attachment, labels, len(rig.neutral.faces))
    markers = virtual_markers(performance, attachment, labels)
    write_c3d(output, markers, up="+Y")


def _face(source: Path, output: Path, options: ConvertOptions) -> None:
    try:
        performance = read_edited(source, tell)
    except BadInput:
        write_any_rig(output, read_any_rig(source, tell=tell))
    else:
        write_any_performance(output, performance)


def _shapes(source: Path, output: Path, options: ConvertOptions) -> None:
    write_any_rig(output, read_any_rig(source, options.units, tell))


def _scan(source: Path, output: Path, options: ConvertOptions) -> None:
    scan = read_scan(source, options.units)
    write_mesh(output, scan.mesh, scan.texture)


def _light_scan(source: Path, output: Path, options: ConvertOptions) -> None:
    from ..light.disk.light_scan import read_light_scan

    write_mesh(output, read_light_scan(source).mesh())


@dataclass(frozen=True)
class Way:
    """One way from format to format."""

    what: str
    """As a list of ways tells it."""
    sources: Collection[str]
    """Suffixes, or `FOLDER`."""
    ends: Collection[str]
    """Suffixes, empty for a folder."""
    go: Callable[[Path, Path, ConvertOptions], None]
    options: tuple[str, ...] = ()
    """Fields of `ConvertOptions` that it heeds."""


WAYS = (
    Way("a marker take to .c3d", MARKERS, (".c3d",), _markers, ("units", "rate", "markers")),
    Way("a Live Link Face .csv to .glb or .usd", (".csv",), WRITTEN, _live_link, ("rate", "rig", "map")),
    Way("a recording of Live Link packets to .glb or .usd", (RECORDING,), WRITTEN, _packets, ("rig", "map")),
    Way("a performance (.glb, .usd) to .csv (Live Link Face)", FACES, (".csv",), _to_live_link),
    Way("a performance to a folder (a mesh a frame)", FACES, ("",), _to_sequence, ("frames_as", "still_head")),
    Way("a performance to .abc (Alembic)", FACES, (SUFFIX,), _to_alembic, ("still_head",)),
    Way("a performance to .c3d (virtual markers)", FACES, (".c3d",), _to_markers, ("attachment", "count")),
    Way("a rig or performance of any program to .glb or .usd", FACES, WRITTEN, _face),
    Way("a folder of shapes to .glb or .usd", (FOLDER,), WRITTEN, _shapes, ("units",)),
    Way("a scan to .obj or .ply", SCANS, MESHES, _scan, ("units",)),
    Way("a scan of active light to .obj or .ply", (".exr",), MESHES, _light_scan),
)
"""All ways; the first that fits is gone."""

OPTIONS = tuple(f"options.{field.name}" for field in fields(ConvertOptions))


def way_from(source: Path, kind: str, end: str) -> Way:
    """The way from one kind to another.

    Raises:
        BadInput: there is none.
    """
    for way in WAYS:
        if kind in way.sources and end in way.ends:
            return way
    from_here = [way for way in WAYS if kind in way.sources]
    there = "; ".join(way.what for way in from_here or WAYS)
    what = kind or "a file without suffix"
    raise BadInput(f"{source}: no way from {what} to {end or FOLDER}; there is: {there}")
