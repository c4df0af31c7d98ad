"""`mien view`: faces in the browser, moving."""

import time
import webbrowser
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..errors import BadInput
from ..viewer.open_files import gather
from ..viewer.page_files import export_page
from ..viewer.server import LOCAL, PORT
from ..viewer.studio import Studio
from .options import refuse_unused, verb
from .outputs import FOLDER, check_outputs


@verb
def view(
    files: list[Path],
    *,
    export: Path | None = None,
    host: str = LOCAL,
    port: int | None = None,
    units: str | None = None,
    textured: Path | None = None,
    open_browser: Annotated[bool, Parameter(name="--open")] = True,
) -> None:
    """Look at performances, rigs and scans in the browser: play, scrub, sliders, curves, overlays, side by side.

    The page runs on this machine alone and needs no network. It stays until Ctrl-C.

    Parameters
    ----------
    files
        Performances and rigs (.glb), scans (.ply, .obj, .stl), side by side; over them the markers (.c3d, .trc, .csv)
        and the video (.mp4) or RGB-D take (a folder, .r3d, .bag) that a performance comes from.
    export
        Write the page into this folder instead: it opens without a server, and can be mailed.
    host
        Listen for other machines: 0.0.0.0 for all of them.
    port
        Where to listen; by default the first free one from 8360 on.
    units
        mm, cm, m, in, or millimetres in one unit as a number; for scans.
    textured
        The rig of `mien rig` that the performances play on, whose textures then change with its shapes.
    open_browser
        Open the browser; --no-open prints the address alone.
    """
    if not files:
        raise BadInput("view: name a file: a performance, a rig or a scan")
    check_outputs({FOLDER: export}, inputs=[*files, textured])
    if export is not None:
        refuse_unused("with --export", "host", "port", "open_browser")
    shown, films = gather(files, units, textured)
    studio = Studio(shown, films)
    if export is not None:
        size = export_page(export, studio.scene(), films)
        print(f"{export}/index.html: {size / 1e6:.1f} MB; open it, or mail the folder")
        return
    serve(studio, host, port, open_browser)


def serve(studio: Studio, host: str, port: int | None, open_browser: bool) -> None:
    """Keep the page up until Ctrl-C."""
    server = studio.open(host, port)
    moved = "" if port is not None or server.server_port == PORT else f" (port {PORT} is taken)"
    print(f"{server.address}{moved}; Ctrl-C ends it", flush=True)
    if host != LOCAL:
        print(f"other machines reach it at port {server.server_port} with that token", flush=True)
    if open_browser:
        webbrowser.open(server.address)
    try:
        while True:
            time.sleep(1.0)
    finally:
        server.shutdown()
        server.server_close()
