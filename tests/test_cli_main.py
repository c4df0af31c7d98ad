"""The command line's edges: usage errors, bad input, faults of the system and Ctrl-C are one line each."""

import errno
import signal
import subprocess
import sys

import pytest

from mien.cli import fetch
from mien.cli.main import PIPELINE, app, main
from mien.errors import BadInput


def told(capsys, *words: str) -> tuple[int, str]:
    """Exit status and the one line on stderr that tells why."""
    with pytest.raises(SystemExit) as stop:
        main(list(words))
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("mien: ")]
    assert len(lines) == 1
    return stop.value.code, lines[0]


@pytest.mark.parametrize("words", [["--help"], *([name, "--help"] for name in PIPELINE)])
def test_every_verb_has_help(words, capsys):
    main_returns(words)
    assert "Usage: mien" in capsys.readouterr().out


def main_returns(words):
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 0


@pytest.mark.parametrize(
    "error", [BadInput("take.c3d: no\n points"), PermissionError(errno.EACCES, "Permission denied", "out.glb")]
)
def test_faults_of_input_and_place_are_one_line(error, capsys, monkeypatch):
    def fail(progress):
        raise error

    monkeypatch.setattr(fetch, "fetch_model", fail)
    status, line = told(capsys, "fetch")
    assert status == 2
    assert line in ("mien: take.c3d: no points", "mien: out.glb: Permission denied")


def test_faults_of_ours_are_not_hidden(monkeypatch):
    def fail(progress):
        raise ZeroDivisionError

    monkeypatch.setattr(fetch, "fetch_model", fail)
    with pytest.raises(ZeroDivisionError):
        main(["fetch"])


PROGRAM = """
import signal
import time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a suite run in the background would ignore it
import mien.cli.fetch as fetch
from mien.cli.main import main
def wait(progress):
    print("ready", flush=True)
    time.sleep(60)
fetch.fetch_model = wait
main(["fetch"])
"""


def test_ctrl_c_ends_with_its_line_and_status_130():
    with subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        assert run.stdout.readline() == b"ready\n"
        run.send_signal(signal.SIGINT)
        _, err = run.communicate(timeout=30)
    assert run.returncode == 130
    assert err.decode().splitlines()[-1].startswith("mien: stopped; outputs that were finished are whole")
    assert "Traceback" not in err.decode()


def test_verbs_are_imported_only_when_called():
    program = "import sys; import mien.cli.main; print([m for m in sys.modules if m in ('numpy', 'numba')])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_one_line_a_verb():
    assert all(app[name].default_command is not None for name in PIPELINE)
