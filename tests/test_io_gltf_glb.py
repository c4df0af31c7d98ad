"""The binary container."""

import struct

import pytest

from gltf_files import performance, refusal
from mien.io.gltf import read_performance, read_rig, write_performance


def test_what_is_not_glb(tmp_path):
    path = tmp_path / "rig.glb"
    assert "no such file" in refusal(read_rig, path)
    for content in (b"", b"glTF", b"hello there, this is no model at all"):
        path.write_bytes(content)
        assert "not a .glb file" in refusal(read_rig, path)
    path.write_bytes(b"glTF" + struct.pack("<II", 1, 40) + bytes(40))
    assert "glTF version 1" in refusal(read_rig, path)


@pytest.mark.parametrize("keep", [0.1, 0.5, 0.9, 0.999])
def test_a_truncated_glb_is_refused(tmp_path, keep):
    write_performance(tmp_path / "perf.glb", performance())
    data = (tmp_path / "perf.glb").read_bytes()
    (tmp_path / "perf.glb").write_bytes(data[: int(keep * len(data))])
    for read in (read_rig, read_performance):
        assert "cut off" in refusal(read, tmp_path / "perf.glb")
