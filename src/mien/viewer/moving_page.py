"""A performance as one page that plays when it is opened, for reports."""

from ..blendshapes.build.masks import TexturedRig
from ..clip import Markers
from ..rig import Performance
from .page_files import single_page
from .studio_scene import Shown, pack_scene

PLAYING = "play"
"""The page begins to play by itself."""

ALIVE = "play,alive"
"""... and its eyes blink and look about, where the take says nothing of them; a button stops that."""


def moving_page(
    performance: Performance,
    name: str,
    markers: Markers | None = None,
    opening: str = PLAYING,
    textured: TexturedRig | None = None,
) -> str:
    """HTML that holds everything and asks nothing of the network; with the markers over the face where given,
    and with textures that change with the shapes."""
    shown = [Shown(name, performance, textured=textured)]
    if markers is not None:
        shown.append(Shown("markers", markers))
    return single_page(pack_scene(shown), opening)
