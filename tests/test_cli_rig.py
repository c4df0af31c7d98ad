"""`mien rig` at its edges."""

import pytest

from mien.cli.main import main


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
