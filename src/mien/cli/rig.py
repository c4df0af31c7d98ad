"""`mien rig`: captures of a person's expressions to a rig whose textures blend with its shapes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..blendshapes.build.rig_files import write_textured_rig
from ..blendshapes.captures import find_captures, neutral_of
from ..blendshapes.corrections import check_names, read_corrections
from ..blendshapes.expression import AUTO, BUNDLED, RigConfig
from ..blendshapes.kept_captures import read_captures
from ..blendshapes.pipeline import BuiltRig, build_rig
from ..blendshapes.scan.pipeline import FusionConfig
from ..faces.bundled import load_face
from ..io.meshes import read_scan
from ..landmarks.detector import require_landmarker
from ..one_line import count
from .bar import bar
from .options import refuse_outside, verb
from .outputs import check_outputs
from .shared_options import PIXELS_MM

TEXTURES = 16, 16384
"""Pixels a side of a texture."""


@verb
def rig(
    captures: Path,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("me.glb"),
    arkit: bool = False,
    artist: str = BUNDLED,
    neutral: str | None = None,
    depth_scale: float | None = None,
    unit: str | None = None,
    corrections: Path | None = None,
    config: Annotated[RigConfig, Parameter(name="*")] = RigConfig(),
    scan: Annotated[FusionConfig, Parameter(name="*")] = FusionConfig(),
) -> None:
    """A folder of captures, one an expression, in; a photo-textured rig out, each capture a shape and a texture.

    A capture is an RGB-D take of a held expression (see `mien scan`), a textured mesh, or a map (.exr); its name is the
    shape's. One that cannot be used is named and left out. Finished scans are kept in `me.work/`, which may be deleted.
    Textures and masks lie beside the rig in `me.textures/`, and `me.rig.json` says which is which.

    Parameters
    ----------
    captures
        The folder.
    output
        Where the rig goes (.glb, .usd).
    arkit
        All 52 ARKit shapes: the bundled face's, transferred and pulled to the captures.
    artist
        The rig's mesh: bundled (the whole head, eyes and teeth), auto (the neutral scan thinned, small triangles at
        mouth and eyes), or a mesh with uv (.obj, .ply) that lies on what `mien scan` writes of the neutral.
    neutral
        The neutral capture, where its name does not say so.
    depth_scale
        Units a metre in the depth images of folders, instead of what their take.json says.
    unit
        Of meshes, where the face's size does not tell: mm, cm, m, in.
    corrections
        Landmarks added, moved or dropped and regions painted out by hand (.json; see docs/conventions.md).
    """
    check_asked(output, [captures, corrections], config, scan)
    by_hand = {} if corrections is None else read_corrections(corrections)
    paths = find_captures(captures)
    names = [path.stem for path in paths]
    calm = neutral_of(names, neutral)
    check_names(by_hand, names)
    on = artist if artist in (BUNDLED, AUTO) else read_scan(Path(artist), "mm").mesh
    require_landmarker()
    with bar() as progress:
        read, lost = read_captures(
            paths=paths,
            neutral=calm,
            work=output.with_suffix(".work"),
            depth_scale=depth_scale,
            unit=unit,
            config=scan,
            progress=progress,
        )
        built = build_rig(read, calm, load_face(), arkit, config, progress, by_hand, on)
    write_textured_rig(output, built.textured)
    tell(built, lost, f"from {count(len(read), 'captures')}; neutral: {calm}", output)


def tell(built: BuiltRig, lost: Sequence[str], source: str, output: Path) -> None:
    """What was left out, and what was made."""
    for line in [*lost, *built.left_out]:
        print(line)
    print(summary(output, built.textured.rig.names, source))


def summary(output: Path | str, names: Sequence[str], source: str) -> str:
    """The line that ends a run."""
    line = f"{output}: {count(len(names), 'shapes')} {source}"
    return line if names else f"{line}; a neutral face alone: --arkit gives it all 52 shapes"


def check_asked(output: Path, inputs: Sequence[Path | None], config: RigConfig, scan: FusionConfig) -> None:
    """Before any work: the output can be written, and the pictures are such as memory holds."""
    check_outputs({"a textured rig": output}, inputs=inputs)
    refuse_outside("config__texture", config.texture, *TEXTURES)
    refuse_outside("scan__pixel_mm", scan.pixel_mm, *PIXELS_MM)
