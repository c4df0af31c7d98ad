"""`mien demo rgbd` without what it needs."""

import pytest

from mien.cli.main import main
from mien.landmarks.model_file import VARIABLE


def test_demo_without_the_landmark_model_is_one_line(tmp_path, monkeypatch, capsys):
    pytest.importorskip("mediapipe")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "nothing.task"))
    with pytest.raises(SystemExit) as stop:
        main(["demo", "rgbd", "-o", str(tmp_path / "out")])
    told = capsys.readouterr().err
    assert stop.value.code == 2
    assert told.count("\n") == 1
    assert "no such file" in told
