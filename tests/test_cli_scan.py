"""`mien scan` at its edges."""

import pytest

from mien.cli.main import main


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["scan", "nowhere"], "no such file"),
        (["scan", "TAKE", "-o", "scan.stl"], "written as .ply or .obj or .exr"),
        (["scan", "TAKE"], "not an OpenEXR file"),
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
