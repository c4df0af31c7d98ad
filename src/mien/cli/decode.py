"""`mien decode`: pictures of active light to detailed scans; its patterns and its calibration."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..errors import BadInput
from ..files import existing
from ..light.disk.light_scan import LightScan, write_light_scan
from ..light.disk.light_take import LightTake, read_light_take
from ..light.pipeline import LightConfig, decode_capture
from ..light.training.clips import TrainingConfig
from .bar import bar
from .options import refuse_unused, verb
from .outputs import FOLDER, check_outputs


@verb
def decode(
    source: Path | None = None,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    calibration: Path | None = None,
    show: Literal["paper", "phase", "moving-phase", "gray", "ramp"] | None = None,
    board: str | None = None,
    projector: str = "1024x768",
    clips: bool = False,
    lamps: bool = False,
    gamma: float = 2.2,
    training: Annotated[TrainingConfig, Parameter(name="*")] = TrainingConfig(),
    light: Annotated[LightConfig, Parameter(name="*")] = LightConfig(),
) -> None:
    """Pictures of a face under a projector's patterns and gradients of light in, detailed scans out.

    A take is a folder: `patterns.json` names the slots of a capture, `calibration.json` the cameras and the projector,
    and each camera has a folder of pictures of its name, capture after capture. One scan is written to an .exr (all
    channels), .ply or .obj; several to a folder. `--show` writes the patterns for a projector instead, and `--board`
    calibrates a camera and a projector from a folder of poses of a checkerboard under `--show gray`. `--clips` takes a
    folder of takes, a clip of a dotted face each, and leaves what `mien detail fit` learns from.

    Parameters
    ----------
    source
        The folder of the take, or of the poses.
    output
        scan.exr by default; a folder for several captures or for patterns; a .json for a calibration.
    calibration
        Instead of the folder's own calibration.json.
    show
        Write these patterns: paper (sinusoids, full-on, lamps), phase (shift and Gray code), moving-phase, gray, ramp.
    board
        Calibrate by a checkerboard of inner corners and mm a square, such as 9x7x75.
    projector
        Its size in pixels, for --show and --board.
    clips
        Follow the dots on the face through each clip and bring all scans into the texture space of the neutral.
    lamps
        One near lamp after the other: their places (mm, camera space), pictures and K from lights.json.
    gamma
        Of the pictures under --lamps: 2.2 stands for sRGB, 1 for linear.
    """
    if show is not None:
        refuse_unused("with --show", "source", "calibration", "board", "light", "clips", "training", "lamps", "gamma")
        return show_patterns(show, projector, output or Path("patterns"))
    if source is None:
        raise BadInput("decode: name a folder of pictures, or --show patterns for a projector")
    if board is not None:
        refuse_unused("with --board", "calibration", "light", "clips", "training", "lamps", "gamma")
        return calibrate_rig(existing(source), board, projector, output or Path("calibration.json"))
    refuse_unused("without --show or --board", "projector")
    if lamps:
        refuse_unused("with --lamps", "calibration", "light", "clips", "training")
        return decode_lamps(source, output or Path("scan.exr"), gamma)
    refuse_unused("without --lamps", "gamma")
    if clips:
        return decode_clips(source, calibration, output or Path("clips"), light, training)
    refuse_unused("without --clips", "training")
    decode_take(source, calibration, output or Path("scan.exr"), light)


def show_patterns(name: str, size: str, folder: Path) -> None:
    """The pictures that a projector is to show."""
    from ..light.disk.pattern_files import pattern_set, write_pattern_pictures

    check_outputs({FOLDER: folder})
    patterns = pattern_set(name, size)
    count = write_pattern_pictures(folder, patterns)
    print(f"{folder}/: {count} pictures, patterns.json ({patterns!r})")


def calibrate_rig(folder: Path, board: str, size: str, output: Path) -> None:
    """A camera and a projector from poses of a board."""
    from ..light.calibrate import calibrate_folder, read_board
    from ..light.disk.pattern_files import pattern_set
    from ..light.light_rig import write_rig

    check_outputs({"a calibration": output})
    told = read_board(board)
    with bar() as progress:
        found, notes = calibrate_folder(folder, pattern_set("gray", size), told, progress=progress)
    write_rig(output, found.rig)
    for note in notes:
        print(note)
    if found.left_out:
        print(f"left out, they do not fit the others: {', '.join(found.left_out)}")
    errors = ", ".join(f"{name} {error:.3f}" for name, error in found.rms_px.items())
    print(f"{output}: reprojection error, px rms: {errors}")


def decode_take(source: Path, calibration: Path | None, output: Path, config: LightConfig) -> None:
    """Every capture of a take; one that cannot be decoded is named and left out."""
    take = read_light_take(source, calibration)
    many = len(take) > 1
    if many:
        check_outputs({FOLDER: output}, [source])
        output.mkdir(parents=True, exist_ok=True)
    else:
        check_outputs({"a scan": output}, [source])
    written = 0
    with bar() as progress:
        for number in range(len(take)):
            progress.update("captures", number, len(take))
            written += decode_one(take, number, output / f"capture_{number:04d}.exr" if many else output, config)
        progress.update("captures", len(take), len(take))
    if not written:
        raise BadInput(f"{source}: no capture could be decoded; the lines above say why")
    print(f"{output}: {written} of {len(take)} captures")


def decode_lamps(source: Path, output: Path, gamma: float) -> None:
    """One face under near lamps, one at a time."""
    from ..light.disk.lamp_take import lamp_scan, read_lamp_take

    check_outputs({"a scan": output}, [source])
    take = read_lamp_take(source, gamma)
    scan, words = lamp_scan(take)
    write_scan(output, scan)
    print(words)
    print(f"{output}: {scan!r}")


def decode_clips(
    source: Path, calibration: Path | None, output: Path, light: LightConfig, training: TrainingConfig
) -> None:
    """Clips of a dotted face to training clips; what cannot be used is named and left out."""
    from ..light.disk.training_clips import read_clip_takes, write_training_clips

    check_outputs({FOLDER: output}, [source])
    takes, notes = read_clip_takes(source, calibration)
    with bar() as progress:
        written = write_training_clips(output, takes, light, training, progress)
    for note in (*notes, *written.notes):
        print(note)
    if not written.frames:
        raise BadInput(
            f"{source}: no capture could be brought into the neutral's texture space; the lines above say why"
        )
    print(
        f"{output}/: {written.frames} frames, {written.vertices:,} vertices, {written.dots} dots: for `mien detail fit`"
    )


def decode_one(take: LightTake, number: int, path: Path, config: LightConfig) -> bool:
    """Decode and write one capture; False, and a line, where it cannot be."""
    try:
        scan = decode_capture(take.capture(number), take.patterns, take.rig, config)
    except BadInput as error:
        print(f"capture {number} left out: {error}")
        return False
    write_scan(path, scan)
    print(f"{path}: {scan!r}")
    return True


def write_scan(path: Path, scan: LightScan) -> None:
    """All channels as EXR, or the surface as a mesh."""
    if path.suffix.lower() == ".exr":
        return write_light_scan(path, scan)
    from ..io.meshes import write_mesh

    write_mesh(path, scan.mesh())
