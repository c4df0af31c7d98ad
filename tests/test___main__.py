"""`python -m mien`."""

import subprocess
import sys

import mien


def test_the_module_runs():
    done = subprocess.run([sys.executable, "-m", "mien", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == mien.__version__
