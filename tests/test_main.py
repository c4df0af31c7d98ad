"""`python -m mien` is `mien`."""

import runpy
import sys

import pytest


def test_the_package_runs_as_a_program(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["mien", "--version"])
    with pytest.raises(SystemExit) as stop:
        runpy.run_module("mien", run_name="__main__")
    assert not stop.value.code
    assert capsys.readouterr().out.strip()
