"""`mien convert`: from one file format to another."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..errors import BadInput
from ..files import existing
from ..io.gltf import read_performance, read_rig, write_performance, write_rig
from ..io.livelink import read_live_link, write_live_link
from ..io.markers import READERS as MARKERS
from ..io.markers import read_marker_file, write_c3d
from ..io.meshes import SUFFIXES as SCANS
from ..io.meshes import WRITERS as MESHES
from ..io.meshes import read_scan, write_mesh
from ..io.meshes.sequence import write_sequence
from ..io.name_map import read_name_map
from ..io.rigs import GLTF, read_any_rig
from .bar import bar
from .options import use_only, verb
from .outputs import ANY, FOLDER, check_outputs
from .play import play_on, tell

OPTIONS = ("units", "rate", "markers", "rig", "map_file", "frames_as", "still")
"""What depends on which way a conversion goes."""

_ROUTES = """a marker take to .c3d; a performance .glb to .csv (Live Link Face) or to a folder (a mesh a frame);
a Live Link Face .csv or a folder of shapes to .glb; a scan to .obj or .ply""".replace("\n", " ")


@verb
def convert(
    source: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    units: str | None = None,
    rate: float | None = None,
    markers: str | None = None,
    rig: Path | None = None,
    map_file: Annotated[Path | None, Parameter(name="--map")] = None,
    frames_as: Literal["ply", "obj"] = "ply",
    still: bool = False,
) -> None:
    """Convert a file: marker takes, performances, rigs, scans.

    Marker take (.c3d .trc .csv) -> .c3d. Performance (.glb) -> Live Link Face .csv, or a folder with a mesh a frame.
    Live Link Face .csv -> .glb. Folder of shapes, or .glb of another program -> .glb. Scan (.obj .ply .stl .glb) ->
    .obj or .ply.

    Parameters
    ----------
    source:
        What to read.
    output:
        What to write; its suffix says what it becomes, no suffix means a folder.
    units:
        Unit of a marker take, a scan or a folder of shapes: mm, cm, m, in or millimetres in one unit.
    rate:
        Frames a second of a marker take or a Live Link Face file that does not say, or says it wrongly.
    markers:
        Of a marker take these alone: a pattern with or without the subject (`Actor:*`), several with commas between.
    rig:
        The face that plays a Live Link Face file; by default the bundled one. What else its file holds stays.
    map_file:
        Pairs of shape names by hand, where spelling does not tell: JSON {"theirs": "jawOpen"}, or CSV.
    frames_as:
        ply or obj, for a mesh a frame.
    still:
        Leave head motion out of a mesh a frame.
    """
    source = existing(source)
    end = output.suffix.lower()
    check_outputs({FOLDER if not end else ANY: output}, inputs=[source, rig])
    kind = "folder" if source.is_dir() else source.suffix.lower()
    mode = f"from {kind} to {end or 'a folder'}"
    if kind in MARKERS and end == ".c3d":
        use_only(mode, OPTIONS, "units", "rate", "markers")
        _markers(source, output, units, rate, markers)
    elif kind == ".csv" and end == ".glb":
        use_only(mode, OPTIONS, "rate", "rig", "map_file")
        _live_link(source, output, rate, rig, map_file)
    elif kind in GLTF and end == ".csv":
        use_only(mode, OPTIONS)
        write_live_link(output, read_performance(source))
    elif kind in GLTF and end == "":
        use_only(mode, OPTIONS, "frames_as", "still")
        with bar() as progress:
            write_sequence(output, read_performance(source), f".{frames_as}", not still, progress)
    elif kind in GLTF and end == ".glb":
        use_only(mode, OPTIONS)
        _glb(source, output)
    elif kind == "folder" and end == ".glb":
        use_only(mode, OPTIONS, "units")
        write_rig(output, read_any_rig(source, units, tell))
    elif kind in SCANS and end in MESHES:
        use_only(mode, OPTIONS, "units")
        scan = read_scan(source, units)
        write_mesh(output, scan.mesh, scan.texture)
    else:
        what = kind or "a file without suffix"
        raise BadInput(f"{source}: no way from {what} to {end or 'a folder'}; there is: {_ROUTES}")
    print(f"wrote {output}")


def _markers(source: Path, output: Path, units: str | None, rate: float | None, only: str | None) -> None:
    take = read_marker_file(source, units, rate, only, whole=True)
    for warning in take.warnings:
        tell(warning)
    write_c3d(output, take.markers, up="+Y" if take.up_source == "file" else None)


def _glb(source: Path, output: Path) -> None:
    try:
        performance = read_performance(source)
    except BadInput:
        write_rig(output, read_rig(source))
    else:
        write_performance(output, performance)


def _live_link(source: Path, output: Path, rate: float | None, rig: Path | None, map_file: Path | None) -> None:
    take = read_live_link(source, rate)
    for line in take.notes:
        tell(line)
    given = {} if map_file is None else read_name_map(map_file)
    if rig is not None:
        play_on(take.alone(), rig, output, given, correctives=False)
        return
    from ..faces.bundled import load_face

    write_performance(output, take.to_performance(load_face().rig, given))
