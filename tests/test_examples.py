"""Every example runs, is short, and says first what it shows."""

import ast
import os
import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
LINES = 40


def test_examples_are_numbered():
    assert [path.name[:3] for path in EXAMPLES] == [f"{i + 1:02d}_" for i in range(len(EXAMPLES))]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example(path, tmp_path, monkeypatch, capsys):
    text = path.read_text()
    assert ast.get_docstring(ast.parse(text))
    assert len(text.splitlines()) <= LINES
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(path), str(tmp_path)])
    runpy.run_path(os.fspath(path), run_name="__main__")
    assert capsys.readouterr().out
