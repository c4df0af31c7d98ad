"""`mien register`: a scan in the bundled face's topology."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..faces.bundled import load_face
from ..faces.registration import RegisterConfig, register_scan, registered_rig
from ..faces.registration_report import registration_record, registration_report
from ..files import whole
from ..io.gltf import write_rig
from ..io.meshes import read_scan
from .bar import bar


def register(
    scan: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("face.glb"),
    report: Path | None = None,
    config: Annotated[RegisterConfig, Parameter(name="*")] = RegisterConfig(),
) -> None:
    """One scan in, of any unit and orientation, with hair and shoulders; the bundled face's topology on it out.

    The face is found by its landmarks (MediaPipe on rendered views); the output carries the 52 expressions, fitted to
    the scan's eyes. Scan a calm face for a rig that rests: the scan's own expression becomes the rig's rest.

    Parameters
    ----------
    scan
        .obj, .ply, .stl or .glb.
    output
        Where the face goes (.glb).
    report
        Where the page with pictures and distance maps goes (.html); `register.json` goes beside it.
    """
    if scan.is_dir():
        raise BadInput(f"{scan}: a folder; give one scan (.obj, .ply, .stl or .glb)")
    if output.suffix.lower() != ".glb":
        raise BadInput(f"{output}: faces are written as .glb; name it so")
    source = read_scan(scan)
    with bar() as progress:
        found = register_scan(source, config=config, progress=progress)
    write_rig(output, registered_rig(found, load_face()))
    if report is not None:
        registration_report(source, found).write(report)
        with whole(report.with_name("register.json")) as temporary:
            temporary.write_text(json.dumps({source.name: registration_record(found)}, indent=1) + "\n")
    error = found.regions["face"]
    print(
        f"{output}: mean distance to the scan {error.mean:.3f} mm (95th percentile {error.p95:.3f} mm) "
        f"over the {error.covered:.0%} of the face that it shows; unit {found.landmarks.unit}"
    )
