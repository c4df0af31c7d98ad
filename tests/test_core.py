"""The core works with none of the extras: they are made impossible to import, then everything is imported."""

import subprocess
import sys

EXTRAS = ("mediapipe", "cv2", "rosbags", "lzfse", "viser", "pxr")

PROGRAM = f"""
import importlib, pkgutil, sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {EXTRAS!r}:
            raise ImportError(name + " is an extra")
sys.meta_path.insert(0, Refuse())
import mien
names = [m.name for m in pkgutil.walk_packages(mien.__path__, "mien.") if not m.name.endswith("__main__")]
for name in names:
    importlib.import_module(name)
from mien.faces import load_face
face = load_face()
import numpy as np
assert face.rig.vertices(np.zeros(len(face.rig.names))).shape == face.rig.neutral.vertices.shape
print(len(names), "modules")
"""


def test_core_imports_and_works_without_extras():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[0]) > 20
