"""`mien rig` at its edges."""

import pytest

from mien.cli.main import main
from mien.cli.rig import summary


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["rig", "nowhere"], "no such file"),
        (["rig", "empty"], "holds no capture"),
        (["rig", "two"], "2 neutral captures"),
        (["rig", "none"], "no capture is called neutral"),
        (["rig", "none", "-o", "me.usd"], "written as .glb"),
    ],
)
def test_bad_input_is_one_line(words, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for folder, names in {"empty": (), "two": ("neutral1", "neutral2"), "none": ("smile", "jaw")}.items():
        (tmp_path / folder).mkdir()
        for name in names:
            (tmp_path / folder / f"{name}.exr").write_text("")
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    assert line in capsys.readouterr().err.strip().splitlines()[-1]


@pytest.mark.parametrize(("names", "alone"), [((), True), (("smile",), False)])
def test_a_neutral_face_alone_is_told_how_to_get_shapes(names, alone):
    assert ("--arkit" in summary("me.glb", names, "from 1 capture; neutral: calm")) == alone
