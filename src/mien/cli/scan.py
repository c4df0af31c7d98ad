"""`mien scan`: a held expression before an RGB-D sensor, or any textured mesh, as one scan of the face."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..blendshapes.captures import read_capture
from ..blendshapes.cylinder_map import mesh_of_map
from ..blendshapes.map_file import write_map
from ..blendshapes.scan.pipeline import FusionConfig
from ..io.meshes import write_mesh
from ..landmarks.detector import require_landmarker
from .bar import bar
from .options import verb
from .outputs import check_outputs


@verb
def scan(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("scan.ply"),
    depth_scale: float | None = None,
    unit: str | None = None,
    config: Annotated[FusionConfig, Parameter(name="*")] = FusionConfig(),
) -> None:
    """An expression held for a few seconds before an RGB-D sensor, the head turning, in; one textured scan out.

    A textured mesh (photogrammetry, laser) enters here too: it is found, brought into face space and laid out alike.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d, a RealSense .bag; or a mesh (.obj, .ply, .stl, .glb) or map (.exr).
    output
        A mesh with its texture beside it (.ply, .obj), or the map itself (.exr): positions, colour and confidence.
    depth_scale
        Units a metre in a folder's depth images, instead of what its take.json says.
    unit
        Of a mesh, where the face's size does not tell: mm, cm, m, in.
    """
    check_outputs({"a scan": output}, inputs=[take])
    require_landmarker()
    with bar() as progress:
        capture = read_capture(take, depth_scale, unit, config, progress)
    if output.suffix.lower() == ".exr":
        write_map(output, capture.map)
    else:
        made = mesh_of_map(capture.map)
        write_mesh(output, made.mesh, made.texture)
    for note in capture.notes:
        print(f"mien: {note}", file=sys.stderr)
    print(f"{output}: {capture.summary}")
