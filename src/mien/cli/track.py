"""`mien track`: an RGB-D take, or a video, becomes an animated face."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..io.gltf import write_performance
from ..io.rgbd import RgbdTake, read_rgbd
from ..io.rgbd.live import Replay, live_frames
from ..io.rgbd.webcam import open_webcam
from ..io.rigs import read_any_rig
from ..landmarks.detector import require_landmarker
from ..landmarks.on_rig import LandmarkMap, landmarks_of
from ..pictures import write_png
from ..progress import Progress
from ..reports.markers import telling_frames
from ..reports.tracking import preview, take_report, weights_section
from ..tracking.pipeline import Tracked, TrackTakeConfig, check_shapes, track_take
from .bar import bar
from .options import refuse_unused, verb
from .outputs import beside as beside_output
from .outputs import check_outputs
from .personalize import beside

CAMERA = "live"
"""The word that stands for this computer's camera in place of a take."""


@verb
def track(
    take: Path,
    *,
    rig: Path | None = None,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("perf.glb"),
    seconds: float = 10.0,
    device: str | None = None,
    depth_scale: float | None = None,
    rate: float | None = None,
    focal: float | None = None,
    picture: Path | None = None,
    report: Path | None = None,
    config: Annotated[TrackTakeConfig, Parameter(name="*")] = TrackTakeConfig(),
) -> None:
    """An RGB-D take or a plain video in; an animated face with head motion out.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d, a RealSense .bag, a video, a folder of colour images; or the word live, for
        this computer's camera (colour alone).
    rig
        The person's rig (.glb, from `mien personalize`). Without it the bundled average face is used: fit for a video,
        poor for depth.
    output
        Where the animated face goes (.glb).
    seconds
        How long to look through a camera.
    device
        Which camera, as FFmpeg calls it (/dev/video0); without it the first.
    depth_scale
        Units a metre in a folder's depth images, instead of what its take.json says.
    rate
        Frames a second, instead of what the take says.
    focal
        Focal length of a video's lens, pixels; without it 60 degrees are assumed across the longer side.
    picture
        Write a contact sheet (.png): colour, depth, tracked face; by default beside the output.
    report
        Write the report (.html); by default beside the output.
    """
    camera = str(take) == CAMERA
    made: dict[str, Path | None] = {"an animated face": output}
    if camera:
        refuse_unused("with this computer's camera", "live", "depth_scale", "rate", "picture", "report")
    else:
        refuse_unused("without this computer's camera", "seconds", "device")
        made |= {"a picture": beside_output(output, picture, ".png"), "a page": beside_output(output, report, ".html")}
    check_outputs(made, inputs=[take, rig])
    require_landmarker()
    source = open_webcam(seconds, device, focal) if camera else read_rgbd(take, depth_scale, rate, focal)
    for note in source.notes:
        print(f"mien: {note}", file=sys.stderr)
    person, landmarks = rig_for(rig)
    played = as_live(source) if config.live and not camera else source
    config = replace(config, live=config.live or camera)
    with bar() as progress:
        tracked = track_take(played, person, landmarks, config=config, progress=progress)
        write_performance(output, tracked.performance)
        if not camera:
            pages = (picture or output.with_suffix(".png"), report or output.with_suffix(".html"))
            show(source, tracked, *pages, progress)
    print(summary(output, tracked, source))
    if tracked.stopped:
        raise BadInput(f"{tracked.stopped}; the {len(tracked.performance)} frames before are in {output}")


def show(take: RgbdTake, tracked: Tracked, picture: Path, report: Path, progress: Progress) -> None:
    """Write the contact sheet and the report."""
    image = preview(take, tracked, telling_frames(tracked.performance, 6), progress=progress)
    write_png(picture, image)
    weights_section(take_report(take, tracked, image), tracked.performance).write(report)


def rig_for(path: Path | None):
    """The rig, and where its landmarks are: from the file beside it, else by looking at it."""
    if path is None:
        from ..faces.bundled import load_face

        return load_face().rig, None
    rig = read_any_rig(path)
    check_shapes(rig, str(path))
    kept = beside(path)
    return rig, LandmarkMap.load(kept, rig.neutral) if kept.is_file() else landmarks_of(rig)


def as_live(take: RgbdTake) -> RgbdTake:
    """The take played by the clock."""
    return replace(take, frames=lambda: live_frames(Replay(take)))


def summary(output: Path, tracked: Tracked, take: RgbdTake) -> str:
    """The line that ends a run."""
    import numpy as np

    performance = tracked.performance
    seen = int(performance.tracked.sum())
    line = f"{output}: {seen} of {len(performance)} frames tracked"
    if tracked.missed:
        line += f", {tracked.missed} came while the tracker was busy"
    if take.has_depth:
        line += f", {np.nanmean(tracked.errors):.2f} mm mean distance from the depth before the fit"
    if take.guessed_camera:
        line += f"; the lens was taken to be {take.camera.fx:.0f} pixels long (say --focal if you know better)"
    return line
