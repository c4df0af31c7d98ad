"""`mien fetch landmarks`."""

import hashlib
import io

import pytest

from mien.cli.fetch import fetch
from mien.cli.main import main
from mien.landmarks import model_file as model


@pytest.fixture
def empty_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(model, "SHA256", hashlib.sha256(b"the model").hexdigest())
    monkeypatch.setattr(model, "_clients", lambda: iter(()))
    return tmp_path / "mien" / model.NAME


def test_the_command_prints_where_it_is(empty_cache, monkeypatch, capsys):
    monkeypatch.setattr(model.urllib.request, "urlopen", lambda *_, **__: io.BytesIO(b"the model"))
    asked = []
    monkeypatch.setattr("mien.cli.fetch.require_landmarker", lambda: asked.append(True))
    fetch()
    assert asked
    assert str(empty_cache) in capsys.readouterr().out


@pytest.mark.parametrize(
    "words",
    ["register s.obj", "personalize t.mp4", "track t.mp4", "scan t.mp4", "demo rgbd --output new", "demo scans -o new"],
)
def test_verbs_that_need_it_say_so_before_any_work(words, monkeypatch, tmp_path, capsys):
    """Files that are empty would be complained of if they were looked at first."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(model.VARIABLE, str(tmp_path / "gone.task"))
    for name in ("s.obj", "t.mp4"):
        (tmp_path / name).touch()
    with pytest.raises(SystemExit) as stop:
        main(words.split())
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "gone.task" in line
    assert sorted(p.name for p in tmp_path.iterdir()) == ["s.obj", "t.mp4"]
