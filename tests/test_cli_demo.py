import pytest

from command import mien
from mien.cli import demo as verb
from mien.errors import BadInput


@pytest.fixture
def ran(tmp_path, monkeypatch):
    """Demonstrations that only say that they ran, and pages that would have opened."""
    calls, opened = [], []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(verb, "run", lambda *words: calls.append(words))
    monkeypatch.setattr("webbrowser.open", opened.append)
    return calls, opened


def test_each_system_has_its_own_folder(ran, tmp_path):
    mien("demo")
    mien("demo", "detail", output="elsewhere")
    assert [str(call[1]) for call in ran[0]] == ["demo/markers", "elsewhere"]
    assert (tmp_path / "demo" / "markers").is_dir()


def test_a_page_opens_only_before_a_person(ran, tmp_path, monkeypatch):
    (tmp_path / "demo" / "markers").mkdir(parents=True)
    (tmp_path / "demo" / "markers" / "report.html").write_text("")
    mien("demo")
    assert ran[1] == []
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    mien("demo", open=False)
    assert ran[1] == []
    mien("demo")
    assert ran[1] == [(tmp_path / "demo" / "markers" / "report.html").as_uri()]


def test_what_does_nothing_is_refused(ran):
    with pytest.raises(BadInput, match="--figures does nothing"):
        mien("demo", figures=True)
    with pytest.raises(BadInput, match="--markers does nothing"):
        mien("demo", "rgbd", markers=9)
