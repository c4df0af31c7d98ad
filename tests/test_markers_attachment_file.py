"""Markers placed by hand."""

import numpy as np
import pytest

from marker_stage import held
from mien.errors import BadInput
from mien.markers.attachment_file import labels_off_face, read_attachment, write_attachment


def test_placements_come_back_as_written(tmp_path):
    places = held()
    labels = tuple(f"m{i}" for i in range(60))
    write_attachment(tmp_path / "a.json", labels, places, off_face=("cap1",))
    assert labels_off_face(tmp_path / "a.json") == ("cap1",)
    back = read_attachment(tmp_path / "a.json", labels[::-1], 100_000)
    np.testing.assert_array_equal(back.faces, places.faces[::-1])
    np.testing.assert_allclose(back.barycentric, places.barycentric, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("not json", "not a JSON file"),
        ('{"b": {"face": 0, "barycentric": [1, 0, 0]}}', "no place given for a"),
        ('{"a": {"face": 99, "barycentric": [1, 0, 0]}}', r"triangle 99 is not among the rig's 0\.\.9"),
        ('{"a": {"face": 1, "barycentric": [1, 1, 0]}}', "add up to 1"),
        ('{"a": 5}', "expected"),
    ],
)
def test_bad_placements_are_refused(tmp_path, text, says):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(BadInput, match=says):
        read_attachment(tmp_path / "a.json", ("a",), 10)
