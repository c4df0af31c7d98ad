"""Outputs appear whole or not at all; where they go is tried before the work."""

import pytest

from mien.errors import BadInput
from mien.files import existing, note_clock, recorded, whole, writable, writable_folder


def test_a_file_appears_with_its_last_byte(tmp_path):
    place = tmp_path / "a.txt"
    with whole(place) as temporary:
        temporary.write_text("new")
        assert temporary.suffix == ".txt"
        assert not place.exists()
    assert place.read_text() == "new"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    place = tmp_path / "a.txt"
    place.write_text("old")

    def fail():
        with whole(place) as temporary:
            temporary.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert place.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_places_that_cannot_be_written_are_named(tmp_path):
    with pytest.raises(BadInput, match="is a folder; name a file"):
        writable(tmp_path)
    with pytest.raises(BadInput, match="does not exist; create it first"):
        writable(tmp_path / "gone" / "a.txt")
    with pytest.raises(BadInput, match="cannot be written there"):
        writable("/proc/a.txt")
    writable(tmp_path / "a.txt")
    assert not list(tmp_path.iterdir())


def test_a_folder_may_be_new_but_no_file(tmp_path):
    writable_folder(tmp_path / "new" / "deep")
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match="is a file; name a folder"):
        writable_folder(tmp_path / "file" / "deep")
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_what_is_read_must_be_there(tmp_path):
    assert existing(str(tmp_path)) == tmp_path
    with pytest.raises(BadInput, match=r"gone\.ply: no such file or folder"):
        existing(tmp_path / "gone.ply")


def test_what_is_written_is_noted_in_order(tmp_path):
    with recorded() as written:
        for name in ("b", "a"):
            with whole(tmp_path / name) as temporary:
                temporary.touch()
        note_clock(tmp_path / "a", 30.0, 12)
    with whole(tmp_path / "c") as temporary:
        temporary.touch()
    note_clock(tmp_path / "c", 30.0, 12)
    assert written.paths == [tmp_path / "b", tmp_path / "a"]
    assert written.clocks == {tmp_path / "a": (30.0, 12)}
