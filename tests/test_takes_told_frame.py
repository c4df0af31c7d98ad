"""A frame told by number or by time."""

import pytest

from mien.errors import BadInput
from mien.takes.told_frame import told_frame


@pytest.mark.parametrize(("told", "frame"), [("120", 120), (" 2.5S ", 75), ("0.5", 15), ("0", 0)])
def test_a_frame_or_a_time(told, frame):
    assert told_frame(told, 30.0, "--neutral") == frame


@pytest.mark.parametrize("told", ["soon", "", "-3", "-1.0s", "infs", "nan."])
def test_neither_is_refused(told):
    with pytest.raises(BadInput, match="--neutral: expected a frame"):
        told_frame(told, 30.0, "--neutral")
