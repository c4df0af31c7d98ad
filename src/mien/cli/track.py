"""`mien track`: an RGB-D take, or a video, becomes an animated face."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..io.edits_file import write_edited
from ..io.rigs import read_any_rig
from ..landmarks.detector import require_landmarker
from ..landmarks.on_rig import LandmarkMap, landmarks_of
from ..pictures import write_png
from ..progress import Progress
from ..reports.markers import telling_frames
from ..reports.tracking import preview, take_report, weights_section
from ..rgbd import RgbdTake
from ..rgbd.live import Replay, live_frames
from ..rgbd.webcam import open_webcam
from ..rig import Rig
from ..tracking.pipeline import Tracked, TrackTakeConfig, check_shapes, track_take
from ..viewer.moving_page import moving_page
from .bar import bar
from .hidden_face import GaugeOptions, Gauges, learnt_gauges
from .options import refuse_unused, verb
from .outputs import check_outputs
from .personalize import beside
from .play import tell
from .record_live_link import record_live_link
from .shared_options import (
    CAMERA,
    LIVE_LINK,
    CameraOptions,
    NamedPages,
    Pages,
    PicturesReading,
    read_pictures,
    tell_notes,
)

SHEET_FRAMES = 6
"""Frames on the contact sheet: a page's width."""
COLOUR_ALONE = (
    "; from colour alone: weights are told; the head's size and distance are guesses, and where the face moves its "
    "place errs by millimetres and its turn by a degree or two"
)
"""What a take without depth cannot be trusted in."""


@verb
def track(
    take: Path,
    *,
    rig: Path | None = None,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("perf.glb"),
    device: Annotated[CameraOptions, Parameter(name="*")] = CameraOptions(),
    reading: Annotated[PicturesReading, Parameter(name="*")] = PicturesReading(),
    rate: float | None = None,
    listen: str | None = None,
    page: bool = False,
    pages: Annotated[Pages, Parameter(name="*")] = Pages(),
    upper: Annotated[GaugeOptions, Parameter(name="*")] = GaugeOptions(),
    config: Annotated[TrackTakeConfig, Parameter(name="*")] = TrackTakeConfig(),
) -> None:
    """An RGB-D take or a plain video in; an animated face with head motion out.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d, a RealSense .bag, a video, a folder of colour images; or a word: live, for
        this computer's camera (colour alone), or livelink, for the Live Link Face app of an iPhone.
    rig
        The person's rig (.glb or .usd, from `mien personalize`). Without it the bundled average face is used: fit for
        a video, poor for depth.
    output
        Where the animated face goes (.glb, .usd).
    page
        Show the face in the browser while it is tracked, beside the sensor's picture, with the time of every stage.
    rate
        Frames a second, instead of what the take says.
    listen
        For livelink: where packets come in, HOST:PORT; by default port 11111 on every network of this computer.
    """
    if str(take) == LIVE_LINK:
        check_outputs({"an animated face": output}, inputs=[rig])
        refuse_unused("for the Live Link Face app", "device.device", "reading", "rate", "pages", "upper", "config")
        record_live_link(listen, rig, output, device.seconds)
        return
    refuse_unused("without livelink", "listen")
    camera = str(take) == CAMERA
    named = None if camera else pages.named_by(output)
    made: dict[str, Path | None] = {"an animated face": output, **(named.outputs if named else {})}
    refuse_of_camera(camera)
    check_outputs(made, inputs=[take, rig, *upper.inputs])
    require_landmarker()
    source = open_source(take, camera, device, reading, rate)
    gauges = learnt_gauges(upper, config.hidden, source)
    person, landmarks = rig_for(rig)
    played = as_live(source) if config.live and not camera else source
    config = replace(config, live=config.live or camera)
    with bar() as progress:
        tracked = with_gauges(tracked_take(played, person, landmarks, config, progress, page), gauges)
        write_edited(output, tracked.performance, tell)
        if named:
            show(source, tracked, named, progress)
    print(summary(output, tracked, source))
    if tracked.stopped:
        raise BadInput(f"{tracked.stopped}; the {len(tracked.performance)} frames before are in {output}")


def refuse_of_camera(camera: bool) -> None:
    """Refuse what does nothing with this computer's camera, or without it."""
    if camera:
        refuse_unused("with this computer's camera", "config.live", "reading.depth_scale", "rate", "pages")
    else:
        refuse_unused("without this computer's camera", "device")


def with_gauges(tracked: Tracked, gauges: Gauges | None) -> Tracked:
    """The same, upper shapes as the gauges say, if there are any."""
    return replace(tracked, performance=gauges.driven(tracked.performance)) if gauges else tracked


def tracked_take(
    take: RgbdTake, rig: Rig, landmarks: LandmarkMap | None, config: TrackTakeConfig, progress: Progress, page: bool
) -> Tracked:
    """The take tracked; with `page` shown in the browser as it goes."""
    from .live_page import LivePage

    if not page:
        return track_take(take, rig, landmarks, config=config, progress=progress)

    live = LivePage(take, rig)
    with live.open():
        return track_take(
            take=live.take,
            rig=rig,
            landmarks=landmarks,
            config=config,
            progress=progress,
            timer=live.feed,
            watch=live.watch,
        )


def open_source(
    take: Path, camera: bool, device: CameraOptions, reading: PicturesReading, rate: float | None
) -> RgbdTake:
    """The camera or the take, its notes told."""
    if camera:
        source = open_webcam(device.seconds, device.device, reading.focal)
        tell_notes(source)
    else:
        source = read_pictures(take, reading, rate)
    if source.has_depth:
        refuse_unused("for a take with depth", "config.video")
    else:
        refuse_unused("for colour alone: its fit is --video", "config.track.fit")
    return source


def show(take: RgbdTake, tracked: Tracked, pages: NamedPages, progress: Progress) -> None:
    """Write the contact sheet and the report."""
    frames = telling_frames(tracked.performance, SHEET_FRAMES)
    image = preview(take, tracked, frames, progress=progress)
    write_png(pages.picture, image)
    report = take_report(take, tracked, image)
    report.page(moving_page(tracked.performance, take.name), "Drag to turn, wheel to come nearer; space plays.")
    weights_section(report, tracked.performance).write(pages.report)


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
    else:
        line += COLOUR_ALONE
    if take.guessed_camera:
        line += f"; the lens was taken to be {take.camera.fx:.0f} pixels long (say --focal if you know better)"
    return line
