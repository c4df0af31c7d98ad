"""`mien personalize`: what is heeded with and without depth."""

from dataclasses import replace
from pathlib import Path

import pytest

import tracking_stage as stage
from command import mien
from mien.cli import personalize
from mien.errors import BadInput


class Enough(Exception):
    """The take has come as far as the work."""


@pytest.fixture
def given(monkeypatch):
    """A calm take in place of a file; what the work is given."""
    seen = {}

    def work(take, **more):
        seen.update(more, take=take)
        raise Enough

    monkeypatch.setattr(personalize, "require_landmarker", lambda: None)
    monkeypatch.setattr(personalize, "read_pictures", lambda *_: stage.calm()[0])
    monkeypatch.setattr(personalize, "make_rig", work)
    monkeypatch.setattr(personalize, "rig_from_images", work)
    return seen


@pytest.mark.parametrize(("told", "frame"), [("3", 3), ("0.1s", 3)])
def test_the_calm_face_begins_where_the_user_says(given, tmp_path, told, frame):
    with pytest.raises(Enough):
        mien("personalize", tmp_path, output=tmp_path / "rig.glb", neutral=told)
    assert given["config"].first == frame
    with pytest.raises(BadInput, match="--first does nothing with --neutral"):
        mien("personalize", tmp_path, output=tmp_path / "rig.glb", neutral=told, first=2)


def test_without_depth_what_needs_depth_is_refused(given, monkeypatch, tmp_path):
    blind = replace(stage.calm()[0], has_depth=False)
    monkeypatch.setattr(personalize, "read_pictures", lambda *_: blind)
    with pytest.raises(BadInput, match="--scan does nothing without depth"):
        mien("personalize", tmp_path, output=tmp_path / "rig.glb", scan=tmp_path / "s.ply")
    with pytest.raises(BadInput, match=r"--aggregate\.voxel does nothing without depth"):
        mien("personalize", tmp_path, output=tmp_path / "rig.glb", aggregate__voxel=2.0)
    with pytest.raises(Enough):
        mien("personalize", tmp_path, output=tmp_path / "rig.glb")
    assert given["take"] is blind


def test_landmarks_lie_beside_the_rig():
    assert personalize.beside(Path("a/me.glb")) == Path("a/me.landmarks.json")
