"""Khronos's glTF validator for tests: `assert_valid_gltf(path)`. Needs node and npm; skips, saying so, without them."""

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

VERSION = "2.0.0-dev.3.10"
SCRIPT = Path(__file__).with_name("validate_gltf.mjs")


def assert_valid_gltf(path: Path) -> None:
    """Fail unless the validator finds neither errors nor warnings in `path`."""
    report = gltf_issues(path)
    assert (report["numErrors"], report["numWarnings"]) == (0, 0), json.dumps(report["messages"], indent=1)


def gltf_issues(path: Path) -> dict:
    """The validator's counts (`numErrors`, `numWarnings`) and `messages`."""
    command = ["node", str(SCRIPT), str(_modules()), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return json.loads(done.stdout)


def _modules() -> Path:
    """The folder where the validator is installed, once for all runs, in the user's cache."""
    if not (shutil.which("node") and shutil.which("npm")):
        pytest.skip("node and npm are needed for Khronos's glTF validator")
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "mien-tests"
    home = cache / f"gltf-validator-{VERSION}"
    if not home.is_dir():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as fresh:
            command = ["npm", "install", "--silent", "--prefix", fresh, f"gltf-validator@{VERSION}"]
            done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
            if done.returncode != 0:
                pytest.skip(f"npm could not install Khronos's glTF validator: {done.stderr.strip()[-200:]}")
            if not home.is_dir():
                shutil.copytree(Path(fresh) / "node_modules", home / "node_modules")
    return home / "node_modules"
