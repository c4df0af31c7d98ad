"""`mien demo`: the whole of one system on the bundled actor."""

import sys
import webbrowser
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from ..landmarks.detector import require_landmarker
from .options import refuse_unused, verb
from .outputs import FOLDER, check_outputs

FOLDERS = Path("demo")
"""Each system's results go into a folder of its own below this one."""


@verb
def demo(
    what: Literal["markers", "scans", "rgbd", "blendshapes", "detail", "light"] = "markers",
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    seed: int = 1,
    seconds: float | None = None,
    markers: int | None = None,
    figures: bool = False,
    open_page: Annotated[bool, Parameter(name="--open")] = True,
) -> None:
    """Stage a performance, record it with faults, solve it, score it against the truth, and show it moving.

    How long each takes on two cores is told first: one to four minutes, rgbd with --figures five.

    Parameters
    ----------
    what
        Which system.
    output
        Folder for the results, made if need be; demo/markers, demo/scans, ... where not given.
    seed
        Which performer.
    seconds
        Length of the take; 12 where not given.
    markers
        How many markers the performer wears; 178 for detail and light, 100 for the others where not given.
    figures
        Redraw the paper's figures too, stages left out one by one (rgbd).
    open_page
        Open the page in the browser where a person is watching; --no-open leaves it.
    """
    folder = FOLDERS / what if output is None else output
    check_outputs({FOLDER: folder})
    if what == "rgbd":
        refuse_unused("in `demo rgbd`, whose film has none", "markers")
    else:
        refuse_unused(f"in `demo {what}`, which has no stages to leave out", "figures")
    if what in ("detail", "blendshapes", "light"):
        refuse_unused(f"in `demo {what}`, whose clips are of one length", "seconds")
    if what == "blendshapes":
        refuse_unused("in `demo blendshapes`, whose film has none", "markers")
    if what in ("scans", "rgbd", "blendshapes"):
        require_landmarker()
    folder.mkdir(parents=True, exist_ok=True)
    run(what, folder, seed, SECONDS if seconds is None else seconds, markers, figures)
    if open_page and sys.stdout.isatty() and (folder / "report.html").is_file():
        webbrowser.open((folder / "report.html").absolute().as_uri())


def run(what: str, folder: Path, seed: int, seconds: float, markers: int | None, figures: bool) -> None:
    """One system's demonstration."""
    print(f"mien: {what}: {TAKES[what]}; the first run compiles for some 20 s more", file=sys.stderr, flush=True)
    if what == "detail":
        from .demo_detail import demo_detail

        demo_detail(folder, seed, markers or 178)
    elif what == "blendshapes":
        from .demo_blendshapes import demo_blendshapes

        demo_blendshapes(folder, seed)
    elif what == "light":
        from .demo_light import demo_light

        demo_light(folder, seed, markers or 178)
    elif what == "rgbd":
        from .demo_rgbd import demo_rgbd

        demo_rgbd(folder, seed, seconds, figures)
    elif what == "scans":
        from .demo_scans import demo_scans

        demo_scans(folder, seed, seconds, markers or 100)
    else:
        from .demo_markers import demo_markers

        demo_markers(folder, seed, seconds, markers or 100)


TAKES = {
    "markers": "about a minute",
    "rgbd": "two minutes",
    "scans": "three minutes",
    "blendshapes": "three to four minutes",
    "detail": "two minutes",
    "light": "four minutes",
}
"""On two cores."""

SECONDS = 12.0
"""Of a take where nothing is said."""
