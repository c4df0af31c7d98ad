"""`mien doctor`."""

import pytest

from command import mien
from mien.cli import doctor
from mien.errors import BadInput


def test_what_is_there_and_the_line_that_adds_what_is_not(capsys, monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "pxr" else object())
    mien("doctor", speed=False)
    told = capsys.readouterr().out
    assert "missing  usd: USD out and in; pip install 'mien[usd]'" in told
    assert "there    stream" in told
    assert "cores" in told
    assert "speed" not in told


@pytest.mark.parametrize(("seconds", "means"), [(0.01, "live at 60"), (0.03, "live at 30"), (0.2, "too slow")])
def test_what_the_speed_means(monkeypatch, seconds, means):
    monkeypatch.setattr(doctor, "tracking_seconds", lambda: seconds)
    assert means in doctor.speed_line()
    monkeypatch.setattr(doctor, "is_busy", lambda: True)
    assert "busy" in doctor.speed_line()


def test_why_it_was_not_tried(monkeypatch):
    def missing():
        raise BadInput("landmarks: MediaPipe is missing")

    monkeypatch.setattr(doctor, "tracking_seconds", missing)
    assert doctor.speed_line() == "speed: not tried (landmarks: MediaPipe is missing)"


def test_a_model_that_is_missing_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("MIEN_FACE_LANDMARKER", str(tmp_path / "none.task"))
    [line] = doctor.model()
    assert line.startswith("missing  landmark model")


def test_frames_are_timed_after_the_first_few(monkeypatch):
    monkeypatch.setattr(doctor, "TEST_S", 0.0)
    came = iter(range(100))
    assert doctor.seconds_each(came) >= 0
    assert next(came) == 6
