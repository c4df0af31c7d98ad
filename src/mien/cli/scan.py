"""`mien scan`: a held expression before an RGB-D sensor, or any textured mesh, as one scan of the face."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..blendshapes.captures import read_capture
from ..blendshapes.cylinder_map import mesh_of_map
from ..blendshapes.map_file import write_map
from ..blendshapes.scan.guide import POSES, GuideConfig
from ..blendshapes.scan.guide import guide as guide_through
from ..blendshapes.scan.pipeline import FusionConfig
from ..depth import RGBDFrame
from ..errors import BadInput
from ..io.meshes import write_mesh
from ..landmarks.detector import FaceLandmarker, require_landmarker
from ..rgbd import RgbdTake, read_rgbd, write_rgbd
from ..rgbd.live import Replay, live_frames
from .bar import bar
from .options import refuse_outside, refuse_unused, verb
from .outputs import FOLDER, check_outputs
from .shared_options import CAMERA, PIXELS_MM


@verb
def scan(
    take: Path,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    depth_scale: float | None = None,
    unit: str | None = None,
    replay: Path | None = None,
    poses: str = ",".join(POSES),
    guide: Annotated[GuideConfig, Parameter(name="*")] = GuideConfig(),
    config: Annotated[FusionConfig, Parameter(name="*")] = FusionConfig(),
) -> None:
    """An expression held for a few seconds before an RGB-D sensor, the head turning, in; one textured scan out.

    A textured mesh (photogrammetry, laser) enters here too: it is found, brought into face space and laid out alike.

    Parameters
    ----------
    take
        An RGB-D folder, a Record3D .r3d, a RealSense .bag; or a mesh (.obj, .ply, .stl, .glb) or map (.exr). The word
        live: a guided session, which says what to do and leaves a folder of captures for `mien rig`.
    output
        A mesh with its texture beside it (.ply, .obj), or the map itself (.exr): positions, colour and confidence; by
        default scan.ply. Of a guided session the folder, by default captures.
    depth_scale
        Units a metre in a folder's depth images, instead of what its take.json says.
    unit
        Of a mesh, where the face's size does not tell: mm, cm, m, in.
    replay
        For live: the recorded RGB-D take that plays the sensor, by the clock.
    poses
        For live: the expressions to ask for, with commas between.
    """
    if str(take) == CAMERA:
        refuse_unused("for a guided session", "unit", "config")
        guided_session(output or Path("captures"), replay, depth_scale, tuple(poses.split(",")), guide)
        return
    refuse_unused("without a guided session", "replay", "poses", "guide")
    output = output or Path("scan.ply")
    refuse_outside("config__pixel_mm", config.pixel_mm, *PIXELS_MM)
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


def guided_session(
    folder: Path, replay: Path | None, depth_scale: float | None, poses: tuple[str, ...], config: GuideConfig
) -> None:
    """One pose after the other until all are captured, each written as soon as it is."""
    if replay is None:
        raise BadInput("scan live: no depth camera is read directly; record a take and give it with --replay TAKE")
    check_outputs({FOLDER: folder}, inputs=[replay])
    require_landmarker()
    take = read_rgbd(replay, depth_scale)
    if not take.has_depth:
        raise BadInput(f"{replay}: has no depth; a scan needs an RGB-D take")
    folder.mkdir(exist_ok=True)
    last, done = "", []
    for told in guide_through(live_frames(Replay(take)), take.camera, FaceLandmarker(), poses, config):
        if told.say != last:
            print(told.say, flush=True)
            last = told.say
        if told.finished is not None:
            frames = told.frames
            write_rgbd(folder / told.finished, short_take(take, frames))
            done.append(told.finished)
    if not done:
        raise BadInput(f"{replay}: no pose was held until it was seen from all sides; the last word was: {last}")
    left = [pose for pose in poses if pose not in done]
    print(f"{folder}/: {', '.join(done)}" + (f"; not captured: {', '.join(left)}" if left else ""))


def short_take(take: RgbdTake, frames: tuple[RGBDFrame, ...]) -> RgbdTake:
    """Some frames of a take as one of their own."""
    return replace(take, count=len(frames), frames=lambda: iter(frames))
