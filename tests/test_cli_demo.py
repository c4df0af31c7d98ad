import pytest

from mien.cli import demo as verb
from mien.cli.main import main


@pytest.fixture
def ran(tmp_path, monkeypatch):
    """Demonstrations that only say that they ran, and pages that would have opened."""
    calls, opened = [], []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(verb, "run", lambda *words: calls.append(words))
    monkeypatch.setattr("webbrowser.open", opened.append)
    return calls, opened


def test_each_system_has_its_own_folder(ran, tmp_path):
    main(["demo"])
    main(["demo", "detail", "-o", "elsewhere"])
    assert [str(call[1]) for call in ran[0]] == ["demo/markers", "elsewhere"]
    assert (tmp_path / "demo" / "markers").is_dir()


def test_a_page_opens_only_before_a_person(ran, tmp_path, monkeypatch):
    (tmp_path / "demo" / "markers").mkdir(parents=True)
    (tmp_path / "demo" / "markers" / "report.html").write_text("")
    main(["demo"])
    assert ran[1] == []
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    main(["demo", "--no-open"])
    assert ran[1] == []
    main(["demo"])
    assert ran[1] == [(tmp_path / "demo" / "markers" / "report.html").as_uri()]


@pytest.mark.parametrize(
    ("words", "told"), [(["demo", "--figures"], "--figures"), (["demo", "rgbd", "--markers", "9"], "--markers")]
)
def test_what_does_nothing_is_refused(ran, capsys, words, told):
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    assert told in capsys.readouterr().err
