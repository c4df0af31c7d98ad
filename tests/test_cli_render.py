"""`mien render` as a user runs it."""

from dataclasses import replace

import av
import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.io.gltf import write_performance, write_rig
from mien.io.meshes import write_mesh
from mien.rig import Performance, Rig
from shown_things import brows_and_cheeks, nodding, run


@pytest.fixture
def rig() -> Rig:
    return brows_and_cheeks()


@pytest.fixture
def performance(rig) -> Performance:
    return nodding(rig)


@pytest.fixture
def files(tmp_path, performance, rig):
    write_performance(tmp_path / "perf.glb", performance)
    write_performance(tmp_path / "other.glb", replace(performance, weights=performance.weights * 0.5))
    write_rig(tmp_path / "rig.glb", rig)
    write_mesh(tmp_path / "scan.ply", rig.neutral.with_vertices(rig.neutral.vertices * 1.05))
    return tmp_path


def size_of(path) -> tuple[int, int]:
    with Image.open(path) as image:
        return image.size


def test_command_draws_stills_sheets_and_films(files, capsys):
    small = ("--size", 64)
    run("render", files / "perf.glb", "-o", files / "a.png", "--frame", 4, *small)
    assert f"wrote {files / 'a.png'}" in capsys.readouterr().out
    assert size_of(files / "a.png") == (64, 64)
    run("render", files / "perf.glb", "-o", files / "b.png", "--sheet", 4, *small)
    assert size_of(files / "b.png") == (132, 132)
    run("render", files / "perf.glb", "-o", files / "c.mp4", *small)
    with av.open(str(files / "c.mp4")) as film:
        assert sum(1 for _ in film.decode(video=0)) == 5
        assert film.streams.video[0].average_rate == 30
    run("render", files / "rig.glb", "-o", files / "d.png", *small)
    assert size_of(files / "d.png") == (132, 132)
    run("render", files / "scan.ply", "-o", files / "e.png", *small)
    assert size_of(files / "e.png") == (64, 64)


@pytest.mark.parametrize(("what", "other", "wide"), [
    ("perf.glb", "other.glb", ("--frame", 4)),
    ("perf.glb", "scan.ply", ("--frame", 4)),
    ("rig.glb", "scan.ply", ("--limit", 2.0)),
    ("scan.ply", "perf.glb", ()),
])  # fmt: skip
def test_command_draws_heat_maps(files, what, other, wide):
    run("render", files / what, "-o", files / "h.png", "--heat", files / other, *wide, "--size", 64)
    width, height = size_of(files / "h.png")
    assert height == 64
    assert width > 100


@pytest.mark.parametrize(("words", "message"), [
    (("perf.glb", "-o", "a.gif"), r"is written as \.png or \.mp4"),
    (("perf.glb", "-o", "a.png", "--frame", "9"), "frame 9: there are 9, counted from 0"),
    (("scan.ply", "-o", "a.png", "--frame", "0"), "--frame does nothing for one picture"),
    (("rig.glb", "-o", "a.png", "--sheet", "0"), "at least"),
    (("scan.ply", "-o", "a.png", "--size", "4"), "16 to 8192"),
    (("scan.ply", "-o", "a.mp4", "--fps", "0"), "must be positive"),
    (("perf.glb", "-o", "a.mp4", "--fps", "-1"), "-1 is below 0"),
    (("perf.glb", "-o", "a.png", "--frame", "1", "--heat", "scan.ply", "--limit", "0"), "limit must be positive"),
    (("perf.glb", "-o", "a.png", "--frame", "1", "--heat", "short.glb"), "as many frames, got 9 and 4"),
    (("none.glb", "-o", "a.png"), "none.glb: no such file"),
    (("cut.glb", "-o", "a.png"), "cut.glb: is cut off"),
    (("perf.glb", "-o", "no/a.png", "--frame", "1"), "does not exist"),
])  # fmt: skip
def test_command_tells_bad_input(files, performance, words, message, monkeypatch):
    monkeypatch.chdir(files)
    (files / "cut.glb").write_bytes((files / "perf.glb").read_bytes()[:-200])
    pose = performance.T_world_face[:4]
    few = replace(performance, weights=performance.weights[:4], T_world_face=pose, tracked=np.ones(4, bool))
    write_performance(files / "short.glb", few)
    before = sorted(files.iterdir())
    with pytest.raises(BadInput, match=message):
        run("render", *words, *(() if "--size" in words else ("--size", 32)))
    assert sorted(files.iterdir()) == before
