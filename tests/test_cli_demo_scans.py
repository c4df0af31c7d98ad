"""`mien demo scans`: scans go to the frames that their names say."""

import json

import pytest

from marker_files import take
from mien.cli import demo_scans
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from small_scans import sheet


class Enough(Exception):
    """The scans have come as far as the registration."""


def test_files_are_read_back_in_the_order_of_the_selection(tmp_path, monkeypatch):
    given = {}

    def staged(folder, *_):
        write_c3d(folder / "take.c3d", take(12))
        (folder / "selection.json").write_text(json.dumps({"frames": [9, 2]}))
        (folder / "scans").mkdir()
        for frame in (2, 9):
            write_mesh(folder / "scans" / f"frame_{frame:06d}.ply", sheet())

    def register(markers, scans, frames, *_, **more):
        given.update(labels=markers.labels, names=[scan.name for scan in scans], frames=frames, **more)
        raise Enough

    monkeypatch.setattr(demo_scans, "stage", staged)
    monkeypatch.setattr("mien.scans.pipeline.register_scans", register)
    with pytest.raises(Enough):
        demo_scans.demo_scans(tmp_path, 1, 12.0, 8)
    assert dict(zip(given["names"], given["frames"], strict=True)) == {"frame_000009": 9, "frame_000002": 2}
    assert given["labels"] == take(12).labels
    assert given["work"] == tmp_path / "rig.work"
