"""`mien demo`: the whole of one system on the bundled actor."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..landmarks.detector import require_landmarker
from .options import refuse_unused, verb
from .outputs import FOLDER, check_outputs


@verb
def demo(
    what: Literal["markers", "scans", "rgbd", "detail"] = "markers",
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("demo"),
    seed: int = 1,
    seconds: float | None = None,
    markers: int | None = None,
) -> None:
    """Stage a performance, record it with faults, solve it, score it against the truth, and show it.

    Parameters
    ----------
    what
        Which system.
    output
        Folder for the results; made if need be.
    seed
        Which performer.
    seconds
        Length of the take; 20 for markers, 12 for the others where not given.
    markers
        How many markers the performer wears; 178 for detail, 100 for the others where not given.
    """
    check_outputs({FOLDER: output})
    if what == "rgbd":
        refuse_unused("in `demo rgbd`, whose film has none", "markers")
    if what == "detail":
        refuse_unused("in `demo detail`, whose clips are of one length", "seconds")
        output.mkdir(parents=True, exist_ok=True)
        from .demo_detail import demo_detail

        return demo_detail(output, seed, markers or 178)
    if what != "markers":
        require_landmarker()
    output.mkdir(parents=True, exist_ok=True)
    if what == "rgbd":
        from .demo_rgbd import demo_rgbd

        return demo_rgbd(output, seed, seconds)
    if what == "scans":
        from .demo_scans import demo_scans

        return demo_scans(output, seed, seconds, markers or 100)
    from .demo_markers import demo_markers

    demo_markers(output, seed, 20.0 if seconds is None else seconds, markers or 100)
