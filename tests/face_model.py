"""Whether the face landmarker's model is at hand; tests that need it skip where it is not."""

import pytest

from mien.errors import BadInput
from mien.landmarks.model_file import model_path


def has_model() -> bool:
    try:
        model_path()
    except BadInput:
        return False
    return True


needs_model = pytest.mark.skipif(not has_model(), reason="no face model: run `mien fetch landmarks`")
