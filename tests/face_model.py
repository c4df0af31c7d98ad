"""Whether the face landmarker can work here (model, MediaPipe, libGL); tests that need it skip where it cannot."""

import pytest

from mien.errors import BadInput
from mien.landmarks.detector import require_landmarker


def why_not() -> str:
    """The line that says what is missing; nothing where nothing is."""
    try:
        require_landmarker()
    except BadInput as error:
        return str(error)
    return ""


needs_model = pytest.mark.skipif(bool(why_not()), reason=why_not())
