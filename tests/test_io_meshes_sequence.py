"""A mesh a frame."""

import numpy as np
import pytest

from gltf_files import performance
from mien.errors import BadInput
from mien.io.meshes import read_scan
from mien.io.meshes.sequence import write_sequence


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
@pytest.mark.parametrize("world", [True, False])
def test_frames_are_the_performance(tmp_path, suffix, world):
    play = performance(4)
    files = write_sequence(tmp_path / "out", play, suffix, world)
    assert [file.name for file in files] == [f"frame_{t:06d}{suffix}" for t in range(4)]
    assert sorted((tmp_path / "out").iterdir()) == files
    for file, mesh in zip(files, play.meshes(world=world), strict=True):
        read = read_scan(file).mesh
        np.testing.assert_allclose(read.vertices, mesh.vertices, atol=5e-5)
        np.testing.assert_array_equal(read.faces, mesh.faces)


def test_progress_is_told(tmp_path):
    told = []

    class Listener:
        def update(self, stage: str, done: int, total: int) -> None:
            told.append((done, total))

    write_sequence(tmp_path / "out", performance(3), progress=Listener())
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_refusals(tmp_path):
    with pytest.raises(BadInput, match=r"use \.obj or \.ply"):
        write_sequence(tmp_path / "out", performance(3), ".fbx")
    with pytest.raises(BadInput, match="does not exist"):
        write_sequence(tmp_path / "no/out", performance(3))
    (tmp_path / "file").write_text("x")
    with pytest.raises(BadInput, match="is a file"):
        write_sequence(tmp_path / "file", performance(3))
