"""The command line's edges: usage errors, bad input, faults of the system and Ctrl-C are one line each."""

import errno
import json
import signal
import subprocess
import sys

import pytest

from gltf_files import performance
from mien.cli import fetch
from mien.cli.main import PIPELINE, app, main
from mien.errors import BadInput
from mien.io.gltf import write_performance
from mien.io.livelink import write_live_link


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


def answer(capsys, *words: str) -> tuple[int, dict]:
    with pytest.raises(SystemExit) as stop:
        main(list(words))
    return stop.value.code, json.loads(capsys.readouterr().out)


def test_json_tells_what_was_written_and_what_went_wrong(tmp_path, capsys):
    write_performance(tmp_path / "a.glb", performance(3))
    status, told = answer(capsys, "convert", str(tmp_path / "a.glb"), "-o", str(tmp_path / "b.glb"), "--json")
    assert (status, told["verb"], told["wrote"]) == (0, "convert", [str(tmp_path / "b.glb")])
    status, told = answer(capsys, "--json", "convert", "none.glb", "-o", str(tmp_path / "b.glb"))
    assert (status, told["error"]) == (2, "none.glb: no such file or folder")


def test_a_file_alone_says_what_it_is(tmp_path, capsys):
    write_performance(tmp_path / "a.glb", performance(3))
    main_returns([str(tmp_path / "a.glb")])
    assert "an animated face" in capsys.readouterr().out


def test_what_was_written_is_followed_by_what_to_do_next(tmp_path, capsys):
    write_performance(tmp_path / "a.glb", performance(3))
    main_returns(["convert", str(tmp_path / "a.glb"), "-o", str(tmp_path / "b.glb")])
    assert f"next: `mien view {tmp_path / 'b.glb'}`" in capsys.readouterr().out


def test_a_verb_that_cannot_use_a_file_names_the_one_that_can(tmp_path, capsys):
    write_live_link(tmp_path / "app.csv", performance(3))
    status, line = told(capsys, "solve", str(tmp_path / "app.csv"), "-o", str(tmp_path / "x.glb"))
    assert status == 2
    assert f"mien convert {tmp_path / 'app.csv'} -o perf.glb" in line


def test_help_is_a_verb_too(capsys):
    main_returns(["help"])
    assert "Verbs, in pipeline order" in capsys.readouterr().out
    main_returns(["help", "fetch"])
    assert "Usage: mien fetch" in capsys.readouterr().out
