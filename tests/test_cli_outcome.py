"""How a verb ends."""

import json
from pathlib import Path

import pytest

from gltf_files import performance, rig
from mien.cli.outcome import as_json, folded, next_steps
from mien.files import Written, recorded
from mien.io import usd
from mien.io.gltf import write_performance, write_rig


def test_many_files_of_a_folder_are_that_folder():
    frames = [Path("frames") / f"{i}.ply" for i in range(20)]
    assert folded([Path("a.glb"), *frames, Path("a.glb"), Path("b.png")]) == ["a.glb", "frames/", "b.png"]


def next_of(write, path, thing) -> list[str]:
    with recorded() as written:
        write(path, thing)
    return next_steps("convert", written)


def test_what_blender_must_be_told(tmp_path):
    first, last = next_of(write_performance, tmp_path / "a.glb", performance(300, 60.0))
    assert f"mien view {tmp_path / 'a.glb'}" in first
    assert last == "Blender keeps 24 frames a second: set 60 before the import, and the timeline's end to 299"
    short = next_of(write_performance, tmp_path / "short.glb", performance(20, 60.0))
    assert short[-1].endswith("set 60 before the import")


@pytest.mark.parametrize("suffix", ["usdc", "usdz"])
def test_usd_is_named_where_it_lies(tmp_path, suffix):
    first, last = next_of(usd.write_performance, tmp_path / f"a.{suffix}", performance(30, 30.0))
    assert f"`mien {tmp_path}/a.{suffix}`" in first
    assert last.endswith("set 30 before the import")


def test_rigs_have_no_rate_and_other_files_no_next_step(tmp_path):
    assert len(next_of(write_rig, tmp_path / "rig.glb", rig())) == 1
    assert len(next_of(usd.write_rig, tmp_path / "rig.usdc", rig())) == 1
    assert next_steps("render", Written([tmp_path / "a.png"])) == []
    assert next_steps("demo", Written([tmp_path / "rig.glb"])) == []


def test_json():
    told = json.loads(as_json("solve", 0, [Path("a.glb")], "one\n\ntwo\n", ""))
    assert told == {"verb": "solve", "status": 0, "wrote": ["a.glb"], "said": ["one", "two"]}
    assert json.loads(as_json("solve", 2, [], "", "no"))["error"] == "no"
