"""`mien retarget`: a performance moves to another rig."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..io.name_map import read_name_map
from ..io.performances import read_any_performance
from ..rig.retarget import CORRECTIVE
from .options import refuse_unused, verb
from .outputs import check_outputs
from .play import play_on, tell


@verb
def retarget(
    performance: Path,
    *,
    to: Path,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("out.glb"),
    correctives: bool = True,
    map_file: Annotated[Path | None, Parameter(name="--map")] = None,
) -> None:
    """A performance in, the same performance on another rig out: coefficients by name, head pose, correctives.

    Parameters
    ----------
    performance
        What `mien track` or `mien solve` wrote (.glb, .usd).
    to
        The rig that is to play it (.glb, .gltf, .vrm, .usd, or a folder of OBJ or PLY). All that a glTF
        file holds stays.
    output
        Where the result goes (.glb, .usd).
    correctives
        Transfer what the blendshapes could not say too; --no-correctives leaves it out.
    map_file
        Pairs of shape names by hand, where spelling does not tell: JSON {"theirs": "jawOpen"}, or CSV.
    """
    check_outputs({"an animated face": output}, inputs=[performance, to])
    given = {} if map_file is None else read_name_map(map_file)
    play = read_any_performance(performance, tell)
    own = [name for name in play.rig.names if name.startswith(CORRECTIVE)]
    if not own:
        refuse_unused("for a performance without correctives", "correctives")
    result, note = play_on(play, to, output, given, correctives)
    moved = len(result.moved)
    line = f"{output}: {moved} shapes and {result.correctives} correctives on {to}{note}"
    if result.dropped:
        dropped = ", ".join(result.dropped)
        line += f"; the target has nothing for {dropped}"
    print(line)
