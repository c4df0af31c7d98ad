"""Pairs of shape names by hand."""

import pytest

from mien.errors import BadInput
from mien.io.name_map import read_name_map


@pytest.mark.parametrize("text", ['{"Mund": "jawOpen", "b": "c"}', "Mund,jawOpen\nb,c\n", "Mund;jawOpen\n\nb; c\n"])
def test_json_or_two_columns(tmp_path, text):
    (tmp_path / "map").write_text(text)
    assert read_name_map(tmp_path / "map") == {"Mund": "jawOpen", "b": "c"}


@pytest.mark.parametrize("text", ["", "Mund\n", "[1, 2]", "{1", '{"a": 1}'])
def test_what_is_no_map_is_refused(tmp_path, text):
    (tmp_path / "map").write_text(text)
    with pytest.raises(BadInput, match=r"needs|is no JSON"):
        read_name_map(tmp_path / "map")
