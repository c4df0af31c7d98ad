"""The bar that every verb shows: one line a stage, on stderr."""

from mien.cli.bar import bar
from mien.progress import Progress


def test_a_line_a_stage_on_stderr(capsys):
    with bar() as progress:
        assert isinstance(progress, Progress)
        for done in range(4):
            progress.update("reading frames", done, 3)
        progress.update("solving", 1, 1)
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.strip().splitlines()
    assert [line.split()[0] for line in lines] == ["reading", "solving"]
    assert "3/3" in lines[0]


def test_a_block_without_a_stage_leaves_nothing(capsys):
    with bar():
        pass
    assert capsys.readouterr() == ("", "")
