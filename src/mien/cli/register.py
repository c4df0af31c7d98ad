"""`mien register`: one scan, or all scans of a take, in the bundled face's topology."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..files import existing, whole
from ..io.rigs import write_any_rig
from ..landmarks.detector import require_landmarker
from .bar import bar
from .options import refuse_outside, refuse_unused, verb
from .outputs import beside, check_outputs

MOST_DENSITY = 4
"""Each subdivision has four times the triangles: 4 make four million."""


@dataclass(frozen=True)
class FolderOptions:
    """What means something for a folder of scans alone."""

    markers: Path | None = None
    """The marker take that the scans belong to (C3D, TRC, CSV)."""
    selection: Path | None = None
    """The frames that were scanned, from `mien select` (.json)."""
    constraints: Path | None = None
    """Points and curves that correspond, by hand (.json; see docs/conventions.md). Reruns only what they touch."""
    template: str | None = None
    """Topology of a folder's rig: a mesh of a face (.obj, .ply, .stl, .glb), or `scan` for the neutral scan's own. By
    default the bundled face's."""
    strict: bool = False
    """Stop at a scan of a folder that is missing or cannot be used; by default it is named and left out."""
    arkit: bool = False
    """Also write the person with all 52 ARKit shapes, pulled to the scans (`face.arkit.glb`): what `mien retarget` and
    Live Link Face recordings can play."""
    units: str | None = None
    """Of the take: mm, cm, m, in, or millimetres in one unit as a number."""
    rate: float | None = None
    """Of the take: frames a second, where the file does not say."""


@verb
def register(
    scans: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("face.glb"),
    density: int | None = None,
    unit: str | None = None,
    report: Path | None = None,
    folder: Annotated[FolderOptions, Parameter(name="*")] = FolderOptions(),
) -> None:
    """A scan of any unit and orientation, with hair and shoulders, in the bundled face's topology; or all of a take's.

    One scan: the face is found by its landmarks (MediaPipe on rendered views); the output carries the 52 expressions,
    fitted to the scan's eyes. Scan a calm face for a rig that rests: the scan's own expression becomes the rig's rest.

    A folder of scans, with the take and the selection that they were made for: a rig with a target a scan, in dense
    correspondence, on which `mien solve --rig` plays takes. A scan belongs to the frame whose number ends its name, or
    as `scans.json` in the folder says. What is known of the rig goes beside it (`face.register.json`); finished steps
    are kept in `face.work/`, so that a stopped run goes on where it was. That folder may be deleted.

    Parameters
    ----------
    scans
        .obj, .ply, .stl or .glb; or a folder of such.
    output
        Where the face goes (.glb, .usd).
    density
        Rounds of subdivision of the result, each with four times the triangles: 0 for one scan, 2 for a folder.
    unit
        Of the scans, where the face's size does not tell: mm, cm, m, in.
    report
        Where the page with pictures and distance maps goes (.html).
    """
    existing(scans)
    page = beside(output, report, ".html") if scans.is_dir() else report
    outputs = {"a face": output, "a page": page}
    if folder.arkit:
        outputs["a face with all 52 shapes"] = beside_arkit(output)
    refuse_outside("density", density, 0, MOST_DENSITY)
    check_outputs(outputs, inputs=[scans, folder.markers, folder.selection])
    if not scans.is_dir():
        refuse_unused("for one scan: it goes with a folder of scans", "folder")
        require_landmarker()
        register_one(scans, output, density or 0, unit, page)
        return
    if folder.markers is None or folder.selection is None:
        raise BadInput(
            f"{scans}: a folder; its scans need the take and the selection that they were made for: "
            "--markers TAKE --selection selection.json (or give one scan)"
        )
    require_landmarker()
    take = (folder.markers, folder.selection)
    made = (output, beside(output, report, ".html"))
    register_folder(scans, take, folder, made, density, unit)


def register_one(path: Path, output: Path, density: int, unit: str | None, report: Path | None) -> None:
    """One scan, no markers."""
    from ..faces.bundled import load_face
    from ..fitting.register_scan import RegisterConfig, register_scan, registered_rig
    from ..io.meshes import read_scan
    from ..reports.single_scan import registration_record, registration_report
    from ..scans.scan_rig import record_beside

    source = read_scan(path, unit)
    with bar() as progress:
        found = register_scan(source, config=RegisterConfig(density=density), progress=progress)
    write_any_rig(output, registered_rig(found, load_face()))
    if report is not None:
        registration_report(source, found).write(report)
        with whole(record_beside(report)) as temporary:
            temporary.write_text(json.dumps({source.name: registration_record(found)}, indent=1) + "\n")
    for note in found.mended:
        print(f"{path}: {note}")
    error = found.regions["face"]
    print(
        f"{output}: mean distance to the scan {error.mean:.3f} mm (95th percentile {error.p95:.3f} mm) "
        f"over the {error.covered:.0%} of the face that it shows; unit {found.landmarks.unit}"
    )


def register_folder(
    place: Path,
    take_files: tuple[Path, Path],
    told: FolderOptions,
    made: tuple[Path, Path],
    density: int | None,
    unit: str | None,
) -> None:
    """All scans of a take and its selection, to a face and a page."""
    from ..faces.bundled import load_face
    from ..image_space.constraints import read_constraints
    from ..io.markers import read_marker_file
    from ..io.meshes import read_scan
    from ..reports.scans import scans_record, scans_report, surface_distances
    from ..scans.pipeline import ScansConfig, register_scans
    from ..scans.scan_files import match_scans, read_scans
    from ..scans.scan_rig import record_beside, write_record
    from ..scans.select.take_selection import read_selection

    (markers, selection), (output, page) = take_files, made
    chosen = read_selection(selection)
    files, unmatched = match_scans(place, chosen.frames, told.strict)
    by_hand = read_constraints(told.constraints) if told.constraints else ()
    take = read_marker_file(existing(markers), told.units, told.rate)
    template = read_scan(told.template) if told.template not in (None, "scan") else told.template
    config = replace(ScansConfig(), strict=told.strict)
    if density is not None:
        config = replace(config, density=density)
    with bar() as progress:
        readable, scans, unread = read_scans(files, unit, told.strict)
        found = register_scans(
            take.markers, scans, [f.frame for f in readable], load_face(), config,
            constraints=by_hand, template=template, work=output.with_suffix(".work"), progress=progress,
        )  # fmt: skip
        distances = surface_distances(found)
        before = kept_before(output) if by_hand else None
        write_any_rig(output, found.scan_rig.rig)
        if told.arkit:
            write_completed(beside_arkit(output), found.scan_rig.rig)
        write_record(record_beside(output), scans_record(found, distances, markers.name))
        scans_report(place.name, found, distances, config).write(page)
    for line in [*take.warnings, *map(str, unmatched + unread), *summary(found, distances)]:
        print(line)
    if found.fine.unreliable.any():
        print(f"the worst first, to click what is the same: mien view {record_beside(output)} {place}")
    if before is not None:
        print(f"before and after: mien view {before} {output}")


def kept_before(output: Path) -> Path | None:
    """The face that a rerun with constraints replaces, kept as `face.before.glb`; None where there is none."""
    if not output.is_file():
        return None
    before = output.with_name(f"{output.stem}.before{output.suffix}")
    shutil.copyfile(output, before)
    return before


def beside_arkit(output: Path) -> Path:
    """Where the rig with all 52 shapes goes: `face.glb` -> `face.arkit.glb`."""
    return output.with_name(f"{output.stem}.arkit{output.suffix}")


def write_completed(path: Path, rig) -> None:
    """The scanned person with all 52 ARKit shapes.

    Raises:
        BadInput: no face is found in pictures of the scans' mesh.
    """
    from ..blendshapes.build.arkit import completed_rig
    from ..faces.bundled import load_face
    from ..landmarks.face_correspondence import match_faces

    face = load_face()
    ruled = match_faces(face.rig, rig)
    whole_rig = completed_rig(rig, face, ruled)
    write_any_rig(path, whole_rig)


def summary(found, distances) -> list[str]:
    """The lines that end the registration of a folder."""
    import numpy as np

    from ..scans.scan_template import FINE_REGIONS

    known = distances[np.isfinite(distances)]
    lines = [
        f"{len(found.scans)} scans in one topology of {len(found.template.mesh.vertices):,} vertices; mean distance to "
        f"the scans {known.mean():.3f} mm (95th percentile {np.quantile(known, 0.95):.3f} mm)"
    ]
    lines[:0] = map(str, found.left_out)
    if found.fine.by_hand is not None:
        lines.append(found.fine.by_hand.told([scan.name for scan in found.scans]))
    for scan, bad in zip(found.scans, found.fine.unreliable, strict=True):
        if bad.any():
            regions = ", ".join(FINE_REGIONS[r].replace("_", " ") for r in np.flatnonzero(bad))
            lines.append(f"not reliable: {scan.name}: {regions}; --constraints helps")
    return lines
