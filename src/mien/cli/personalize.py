"""`mien personalize`: a calm face before an RGB-D camera becomes that person's rig."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..io.meshes import write_mesh
from ..io.rigs import write_any_rig
from ..landmarks.detector import require_landmarker
from ..rgbd import RgbdTake
from ..takes.told_frame import told_frame
from ..tracking.person.personalize import PersonalizeConfig
from ..tracking.person.personalize import personalize as make_rig
from ..tracking.person.rig_from_images import rig_from_images
from .bar import bar
from .options import refuse_unused, verb
from .outputs import check_outputs
from .shared_options import PicturesReading, read_pictures


@verb
def personalize(
    take: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("rig.glb"),
    scan: Path | None = None,
    neutral: str | None = None,
    reading: Annotated[PicturesReading, Parameter(name="*")] = PicturesReading(),
    config: Annotated[PersonalizeConfig, Parameter(name="*")] = PersonalizeConfig(),
) -> None:
    """An RGB-D take of a calm face in; that person's rig with 52 (or 23) expressions out.

    Colour video alone will do where there is nothing else: the face is then fitted to landmarks, its size is a guess.

    Beside the rig goes `NAME.landmarks.json`: where the landmark detector sees its points on this very face.
    `mien track` looks for it there.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d, a RealSense .bag or a video whose first second or two show the face calm.
    output
        Where the rig goes (.glb, .usd).
    scan
        Write the merged depth too (.ply).
    neutral
        Where the face begins to be at rest: a frame (120, counted from 0) or a time (2.5s); the first without.
    """
    check_outputs({"a rig": output, "a merged scan": scan}, inputs=[take])
    require_landmarker()
    source = read_pictures(take, reading)
    if neutral is not None:
        refuse_unused("with --neutral", "config.first")
        config = replace(config, first=told_frame(neutral, source.rate, "--neutral"))
    if not source.has_depth:
        refuse_unused("without depth", "scan", "config.aggregate", "config.identity")
        from_video(source, output, config)
        return
    with bar() as progress:
        person = make_rig(source, config=config, progress=progress)
    write_any_rig(output, person.rig)
    person.landmarks.save(beside(output))
    if scan is not None:
        write_mesh(scan, person.scan)
    print(
        f"{output}: {len(person.rig.names)} shapes; {person.merged} frames merged, {person.neutral.wrapped:.2f} mm "
        f"mean distance from the scan ({person.neutral.fitted:.2f} before the shrink-wrap)"
    )
    print(person.neutrality)


def from_video(source: RgbdTake, output: Path, config: PersonalizeConfig) -> None:
    """The same without depth."""
    with bar() as progress:
        portrait = rig_from_images(source, config=config, progress=progress)
    write_any_rig(output, portrait.rig)
    portrait.landmarks.save(beside(output))
    print(
        f"{output}: {len(portrait.rig.names)} shapes, from colour alone; landmarks {portrait.average:.2f} mm off the "
        f"average face, {portrait.fitted:.2f} mm off the fitted one"
    )
    print(portrait.neutrality)


def beside(rig: Path) -> Path:
    """Where a rig's landmarks are kept."""
    return rig.with_suffix(".landmarks.json")
