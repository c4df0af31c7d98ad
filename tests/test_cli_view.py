import threading

import pytest

from command import mien
from mien.errors import BadInput
from mien.io.gltf import write_performance
from studio_things import nodding


@pytest.fixture
def perf(tmp_path):
    write_performance(tmp_path / "perf.glb", nodding(3))
    return tmp_path / "perf.glb"


def test_a_page_is_written(perf, tmp_path, capsys):
    mien("view", perf, export=tmp_path / "page")
    assert (tmp_path / "page" / "index.html").is_file()
    assert "index.html" in capsys.readouterr().out


def test_a_page_is_served_until_it_is_stopped(perf, capsys, monkeypatch):
    opened, before = [], set(threading.enumerate())
    monkeypatch.setattr("webbrowser.open", opened.append)

    def stop(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("time.sleep", stop)
    with pytest.raises(KeyboardInterrupt):
        mien("view", perf)
    assert opened[0].startswith("http://127.0.0.1:")
    assert opened[0] in capsys.readouterr().out
    for left in set(threading.enumerate()) - before:
        left.join(30)
        assert not left.is_alive()


def test_other_machines_are_let_in_only_when_told(perf, capsys, monkeypatch):
    monkeypatch.setattr("time.sleep", lambda _: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(KeyboardInterrupt):
        mien("view", perf, host="0.0.0.0", open=False)
    assert "other machines reach it" in capsys.readouterr().out


def test_what_does_nothing_is_refused(perf, tmp_path):
    with pytest.raises(BadInput, match="--port does nothing"):
        mien("view", perf, export=tmp_path / "page", port=8000)
    with pytest.raises(BadInput, match="no such file"):
        mien("view", tmp_path / "away.glb")
