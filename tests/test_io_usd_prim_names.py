"""Identifiers for any names."""

from mien.io.usd.prim_names import prim_names


def test_every_name_has_an_identifier_of_its_own():
    assert prim_names(["jawOpen", "jaw Open", "jaw_Open", "JAWOPEN", "2nd", "", "ü"]) == [
        "jawOpen",
        "jaw_Open",
        "jaw_Open_2",
        "JAWOPEN_2",
        "_2nd",
        "_",
        "__2",
    ]
