"""`mien fetch landmarks`."""

import hashlib
import io

import pytest

from mien.cli.fetch import fetch
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
