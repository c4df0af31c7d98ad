"""Text in the encodings that programs write."""

import codecs

import pytest

from mien.errors import BadInput
from mien.text.decode_text import decode_bytes, decode_text

TEXT = "Frame;Länge\n1;2,5\n" * 20


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode("utf-8"),
        TEXT.encode("utf-8-sig"),
        TEXT.encode("utf-16"),
        codecs.BOM_UTF16_BE + TEXT.encode("utf-16-be"),
        TEXT.encode("utf-16-le"),
        TEXT.encode("utf-16-be"),
        TEXT.encode("latin-1"),
    ],
    ids=["utf-8", "marked", "utf-16", "big-endian", "unmarked", "unmarked big-endian", "latin-1"],
)
def test_every_encoding_gives_the_text(tmp_path, data):
    (tmp_path / "a.csv").write_bytes(data)
    assert decode_text(tmp_path / "a.csv") == TEXT


def test_binary_is_refused(tmp_path):
    with pytest.raises(BadInput, match="is binary, not text"):
        decode_bytes(tmp_path / "a.csv", b"Frame\x00\x01\x02 and more text that goes on")


def test_nothing_is_no_text_but_no_fault(tmp_path):
    assert decode_bytes(tmp_path / "a.csv", b"") == ""
