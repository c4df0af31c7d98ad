"""`mien personalize`: a calm face before an RGB-D camera becomes that person's rig."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..io.gltf import write_rig
from ..io.meshes import write_mesh
from ..io.rgbd import read_rgbd
from ..tracking.personalize import PersonalizeConfig
from ..tracking.personalize import personalize as make_rig
from .bar import bar


def personalize(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("rig.glb"),
    scan: Path | None = None,
    depth_scale: float | None = None,
    config: Annotated[PersonalizeConfig, Parameter(name="*")] = PersonalizeConfig(),
) -> None:
    """An RGB-D take of a calm face in; that person's rig with 52 (or 23) expressions out.

    Beside the rig goes `NAME.landmarks.json`: where the landmark detector sees its points on this very face.
    `mien track` looks for it there.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d or a RealSense .bag whose first second or two show the face calm.
    output
        Where the rig goes (.glb).
    scan
        Write the merged depth too (.ply).
    depth_scale
        Units a metre in a folder's depth images, instead of what its take.json says.
    """
    if output.suffix.lower() != ".glb":
        raise BadInput(f"{output}: rigs are written as .glb; name it so")
    source = read_rgbd(take, depth_scale)
    with bar() as progress:
        person = make_rig(source, config=config, progress=progress)
    write_rig(output, person.rig)
    person.landmarks.save(beside(output))
    if scan is not None:
        write_mesh(scan, person.scan)
    print(
        f"{output}: {len(person.rig.names)} shapes; {person.merged} frames merged, {person.neutral.wrapped:.2f} mm "
        f"mean distance from the scan ({person.neutral.fitted:.2f} before the shrink-wrap)"
    )


def beside(rig: Path) -> Path:
    """Where a rig's landmarks are kept."""
    return rig.with_suffix(".landmarks.json")
