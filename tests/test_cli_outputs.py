"""Where results go is checked before the work: every output option of every verb."""

import os
from pathlib import Path

import numpy as np
import pytest

from mien.cli.main import main
from mien.cli.outputs import FOLDER, KINDS, beside, check_outputs
from mien.clip import Markers
from mien.errors import BadInput
from mien.io.markers import write_c3d

OUTPUTS = {
    "solve take.c3d": ("--output .glb", "--picture .png", "--report .html", "--save-attach .json"),
    "select take.c3d --video film.mp4": ("--output .json", "--sheet .png"),
    "register scan.obj": ("--output .glb", "--report .html"),
    "personalize film.mp4": ("--output .glb", "--scan .ply"),
    "track film.mp4": ("--output .glb", "--picture .png", "--report .html"),
    "retarget perf.glb --to rig.glb": ("--output .glb",),
    "render scan.obj": ("--output .png",),
}
"""A verb's command line -> its options that name a file, and a suffix that it may have."""

CASES = [(words, *option.split()) for words, options in OUTPUTS.items() for option in options]


@pytest.fixture
def refused(tmp_path, monkeypatch, capsys):
    """What a command line is refused with: one line, exit status 2, nothing written."""
    monkeypatch.chdir(tmp_path)
    write_c3d("take.c3d", Markers(np.zeros((2, 1, 3)), ("a",), 30.0))
    for name in ("scan.obj", "film.mp4", "perf.glb", "rig.glb"):
        Path(name).write_text("")

    def call(words: list[str]) -> str:
        before = sorted(os.listdir())
        with pytest.raises(SystemExit) as stop:
            main(words)
        assert stop.value.code == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert sorted(os.listdir()) == before
        return line.removeprefix("mien: ")

    return call


@pytest.mark.parametrize(("words", "option", "suffix"), CASES)
def test_every_output_of_every_verb(words, option, suffix, refused):
    needed = [] if option == "--output" else ["--output", f"out{OUTPUTS[words][0].split()[1]}"]
    call = [*words.split(), *needed, option]
    Path(f"folder{suffix}").mkdir()
    assert refused([*call, f"folder{suffix}"]) == f"folder{suffix}: is a folder; name a file"
    assert refused([*call, "out.fbx"]).startswith("out.fbx: ")
    assert "the folder missing does not exist; create it first" in refused([*call, f"missing/out{suffix}"])
    place = f"/proc/out{suffix}"
    assert refused([*call, place]).startswith(f"{place}: cannot be written there: ")


def test_convert_and_demo(refused):
    Path("out.glb").mkdir()
    assert refused(["convert", "perf.glb", "-o", "out.glb"]) == "out.glb: is a folder; name a file"
    assert refused(["convert", "take.c3d", "-o", "take.c3d"]).startswith("take.c3d: is read and would be overwritten")
    assert refused(["demo", "-o", "scan.obj"]).startswith("scan.obj: is a file; name a folder")
    assert refused(["demo", "-o", "/proc/demo"]).startswith("/proc/")


@pytest.mark.parametrize(
    "words", ["solve take.c3d --rig perf.glb -o perf.glb", "retarget perf.glb --to rig.glb -o rig.glb"]
)
def test_an_input_is_not_overwritten(words, refused):
    assert "is read and would be overwritten; give the output another name" in refused(words.split())


def test_an_input_by_another_way_is_not_overwritten(tmp_path):
    source = tmp_path / "a.png"
    source.touch()
    os.symlink(source, tmp_path / "b.png")
    with pytest.raises(BadInput, match="is read and would be overwritten"):
        check_outputs({"a picture": tmp_path / "b.png"}, inputs=["live", None, source])


def test_two_outputs_do_not_share_a_name(tmp_path):
    with pytest.raises(BadInput, match="two outputs have this name"):
        check_outputs({"a selection": tmp_path / "a.json", "where markers sit": tmp_path / "a.json"})


def test_what_can_be_written_passes_and_leaves_nothing(tmp_path):
    kinds = {kind: tmp_path / f"{i}{suffixes[-1]}" for i, (kind, suffixes) in enumerate(KINDS.items())}
    check_outputs({**kinds, FOLDER: tmp_path / "new" / "folder"})
    assert not list(tmp_path.iterdir())


def test_names_beside():
    assert beside(Path("a/b.glb"), None, ".html") == Path("a/b.html")
    assert beside(Path("a/b.glb"), Path("c.html"), ".html") == Path("c.html")
