"""Switch every named step of the pipelines off, one by one, and list what no test misses.

`python tools/mutants.py [WORD ...]` runs the lines of `mutant_steps.txt` that hold one of the words, all without; all
of them take about half an hour on two cores. A step is switched off by a stand-in (`tools/mutant_plugin.py`), and the
nearest tests run until the first that fails: the test file of the step's module, or those that stand after `|`. Exit
status 1 where a step is missed by none.
"""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
LIMIT_S = 300
"""A mutant whose tests take longer counts as missed: it hangs."""
PLAIN = "addopts=--strict-markers"
"""Types are not checked while a step is off: what notices must be a test."""

STEPS = HERE / "tools" / "mutant_steps.txt"


def steps() -> list[str]:
    """The lines of the list."""
    lines = STEPS.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and not line.startswith("#")]


def test_files(line: str) -> list[str]:
    """The tests that are nearest to a step."""
    place, _, told = line.partition("|")
    module = place.partition(":")[0].strip().replace(".", "_").replace("__", "_")
    patterns = told.split() or [f"test_{module}"]
    return sorted({str(path) for pattern in patterns for path in (HERE / "tests").glob(f"{pattern}.py")})


def outcome(line: str) -> str:
    """`noticed`, `MISSED`, `no tests`, or why the step could not be switched off."""
    files = test_files(line)
    if not files:
        return "no tests"
    environment = {**os.environ, "MIEN_MUTANT": line.partition("|")[0].strip()}
    environment["PYTHONPATH"] = os.pathsep.join([str(HERE / "src"), str(HERE / "tools")])
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-o", PLAIN, "-p", "mutant_plugin", *files]
    try:
        done = subprocess.run(command, cwd=HERE, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return "MISSED (tests do not end)"
    if done.returncode == 1:
        return "noticed"
    return "MISSED" if done.returncode == 0 else f"cannot be run: {(done.stderr or done.stdout).strip()[-300:]}"


def main(words: list[str]) -> int:
    """Run them, printing as they come; how many no test missed."""
    lines = [line for line in steps() if not words or any(word in line for word in words)]
    missed = 0
    for line in lines:
        told = outcome(line)
        missed += told != "noticed"
        print(f"{told:<10} {line.partition('|')[0].strip()}", flush=True)
    print(f"{len(lines)} steps switched off, {missed} of them unnoticed")
    return missed


if __name__ == "__main__":
    sys.exit(bool(main(sys.argv[1:])))
