"""The core works with none of the extras: they are made impossible to import, then everything is imported but what is
one extra's alone, and which its package imports when it is called.

And the public names: each is there, `import mien` brings none of them yet, and is quick.
"""

import subprocess
import sys
from pathlib import Path

import pytest

import mien

OF_ONE_EXTRA = ("mien.io.usd.",)
EXTRAS = ("mediapipe", "cv2", "rosbags", "lzfse", "viser", "pxr", "pythonosc", "alembic3d")

PROGRAM = f"""
import importlib, pkgutil, sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {EXTRAS!r}:
            raise ImportError(name + " is an extra")
sys.meta_path.insert(0, Refuse())
import mien
names = [m.name for m in pkgutil.walk_packages(mien.__path__, "mien.") if not m.name.endswith("__main__")]
names = [name for name in names if not name.startswith({OF_ONE_EXTRA!r})]
for name in names:
    importlib.import_module(name)
for name in dir(mien):
    getattr(mien, name)
face = mien.load_face()
import numpy as np
assert face.rig.vertices(np.zeros(len(face.rig.names))).shape == face.rig.neutral.vertices.shape
from mien.landmarks.detector import require_landmarker
from mien.extras import require
for extra, call in (
    ("mien[landmarks]", require_landmarker),
    ("mien[realsense]", lambda: mien.read_rgbd(BAG)),
    ("mien[record3d]", lambda: mien.read_rgbd(R3D)),
    ("mien[stream]", lambda: require("pythonosc", "stream")),
    ("mien[alembic]", lambda: require("alembic3d", "alembic")),
    ("mien[usd]", lambda: mien.write_rig("a.usd", face.rig)),
):
    try:
        call()
    except mien.BadInput as error:
        print(extra in str(error), error, file=sys.stderr)
print(len(names), "modules")
"""

QUICK_S = 0.1
"""`import mien`, seconds of processor time."""


def run(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)


def test_core_imports_and_works_without_extras(tmp_path):
    for name in ("a.bag", "a.r3d"):
        (tmp_path / name).write_bytes(b"#ROSBAG V2.0\n" + bytes(64))
    places = f"BAG, R3D = {str(tmp_path / 'a.bag')!r}, {str(tmp_path / 'a.r3d')!r}\n"
    done = run(places + PROGRAM)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) > 20
    assert done.stderr.count("True") == 6, done.stderr


def test_import_brings_nothing_yet_and_is_quick():
    program = """
import sys, time
before = time.process_time()
import mien
spent = time.process_time() - before
heavy = [name for name in sys.modules if name in ("numpy", "scipy", "numba") or name.startswith("mien.")]
print(spent, heavy)
"""
    spent, heavy = run(program).stdout.split(maxsplit=1)
    assert float(spent) < QUICK_S
    assert heavy.strip() == "[]"


def test_public_names_are_there_and_listed_for_editors():
    for name in dir(mien):
        assert getattr(mien, name) is not None
    source = Path(mien.__file__).read_text()
    assert all(f" as {name}\n" in source for name in dir(mien) if not name.startswith("__"))


def test_a_name_that_is_not_there():
    with pytest.raises(AttributeError, match="no_such_name"):
        mien.no_such_name  # noqa: B018
