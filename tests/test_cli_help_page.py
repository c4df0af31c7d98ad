"""A verb's help: docstring, two examples, and the solvers' settings on demand alone."""

import pytest

from mien.cli.help_page import described, epilogue
from mien.cli.main import PIPELINE, main


def page(capsys, *words: str) -> str:
    with pytest.raises(SystemExit) as stop:
        main(list(words))
    assert stop.value.code == 0
    return capsys.readouterr().out


def test_settings_of_solvers_stand_behind_help_all(capsys):
    short = page(capsys, "solve", "--help")
    assert "--face.link-mm" not in short
    assert "--markers" in short
    assert "mien solve take.c3d" in short
    assert "in; an animated face" in short
    assert "--face.link-mm" in page(capsys, "solve", "--help-all")
    assert "--face.link-mm" not in page(capsys, "solve", "--help")


def test_a_docstring_without_its_parameters():
    assert described("A line.\n\n    More.\n\n    Parameters\n    ----------\n    x\n        y\n") == "A line.\n\nMore."


@pytest.mark.parametrize("verb", list(PIPELINE))
def test_every_verb_has_two_examples(verb):
    lines = epilogue(verb, everything=True).split("\n\n")
    assert len(lines) == 3
    assert all(line.startswith(f"`mien {verb}") for line in lines[1:])
