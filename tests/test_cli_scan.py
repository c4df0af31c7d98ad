"""`mien scan` at its edges."""

import pytest

import mien.cli.scan as scan_verb
from mien.blendshapes.scan.guide import Guided
from mien.cli.main import main
from mien.rgbd import read_rgbd, write_rgbd
from rgbd_takes import made


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["scan", "nowhere"], "no such file"),
        (["scan", "TAKE", "-o", "scan.stl"], "written as .ply or .obj or .exr"),
        (["scan", "TAKE"], "not an OpenEXR file"),
        (["scan", "live"], "give it with --replay TAKE"),
        (["scan", "live", "--replay", "nowhere"], "no such file"),
        (["scan", "TAKE", "--poses", "smile"], "--poses does nothing without a guided session"),
        (["scan", "live", "--unit", "mm"], "--unit does nothing for a guided session"),
    ],
)
def test_bad_input_is_one_line(words, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mien.cli.scan.require_landmarker", lambda: None)
    (tmp_path / "take.exr").write_bytes(b"nothing of the kind")
    with pytest.raises(SystemExit) as stopped:
        main([word.replace("TAKE", "take.exr") for word in words])
    assert stopped.value.code == 2
    told = capsys.readouterr().err.strip().splitlines()[-1]
    assert line in told


def test_a_guided_session_says_each_thing_once_and_leaves_a_folder_of_captures(tmp_path, monkeypatch, capsys):
    write_rgbd(tmp_path / "clip", made(3))
    frames = tuple(made(2))
    steps = [Guided("neutral: hold still"), Guided("neutral: hold still"), Guided("smile next", "neutral", frames)]
    monkeypatch.setattr(scan_verb, "require_landmarker", lambda: None)
    monkeypatch.setattr(scan_verb, "FaceLandmarker", lambda: None)
    monkeypatch.setattr(scan_verb, "guide_through", lambda *_: iter(steps))
    session = ["scan", "live", "--replay", str(tmp_path / "clip"), "--poses", "neutral,smile"]
    with pytest.raises(SystemExit) as ended:
        main([*session, "-o", str(tmp_path / "captures")])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert said.count("hold still") == 1
    assert "neutral; not captured: smile" in said
    assert len(read_rgbd(tmp_path / "captures" / "neutral")) == 2
    monkeypatch.setattr(scan_verb, "guide_through", lambda *_: iter(steps[:1]))
    with pytest.raises(SystemExit) as stopped:
        main([*session, "-o", str(tmp_path / "none")])
    assert stopped.value.code == 2
    assert "the last word was: neutral: hold still" in capsys.readouterr().err
