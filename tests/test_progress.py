"""Anything with `update` may watch; nobody need."""

from mien.progress import SILENT, Progress


def test_who_has_update_is_progress():
    class Watcher:
        def update(self, stage: str, done: int, total: int) -> None:
            self.last = (stage, done, total)

    watcher = Watcher()
    assert isinstance(watcher, Progress)
    assert not isinstance(object(), Progress)
    watcher.update("reading", 1, 2)
    assert watcher.last == ("reading", 1, 2)


def test_silence_is_the_default_and_says_nothing(capsys):
    assert isinstance(SILENT, Progress)
    SILENT.update("reading", 1, 2)
    assert capsys.readouterr() == ("", "")
