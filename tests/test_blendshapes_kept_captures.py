"""Captures read once, bad ones left out."""

import pytest

from blendshape_faces import face_map
from mien.blendshapes import kept_captures
from mien.blendshapes.captures import Capture
from mien.blendshapes.kept_captures import read_captures
from mien.errors import BadInput


@pytest.fixture
def reads(monkeypatch):
    names = []

    def read(path, *_):
        names.append(path.stem)
        if path.stem == "broken":
            raise BadInput(f"{path.name}: shows no face")
        return Capture(face_map(), "made")

    monkeypatch.setattr(kept_captures, "read_capture", read)
    return names


def test_finished_captures_are_kept_and_a_bad_one_is_left_out(tmp_path, reads):
    paths = [tmp_path / name for name in ("broken.ply", "neutral.ply", "smile.ply")]
    for path in paths:
        path.write_text("a")
    read, lost = read_captures(paths, "neutral", tmp_path / "work")
    assert [capture.name for capture in read] == ["neutral", "smile"]
    assert lost == ["left out: broken.ply: shows no face"]
    paths[2].write_text("changed")
    read_captures(paths, "neutral", tmp_path / "work")
    assert reads == ["broken", "neutral", "smile", "broken", "smile"]
    with pytest.raises(BadInput, match="shows no face"):
        read_captures(paths, "broken", tmp_path / "work")
