"""What the input is at fault for is a ValueError, so that a library's caller need not know of ours."""

from mien.errors import BadInput


def test_bad_input_is_a_value_error_with_its_line():
    assert issubclass(BadInput, ValueError)
    assert str(BadInput("take.c3d: no points")) == "take.c3d: no points"
