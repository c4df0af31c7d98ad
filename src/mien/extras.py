"""Packages that not everybody has: what each extra brings, and the one line that says that it is missing."""

from importlib import import_module
from types import ModuleType

from .errors import BadInput

EXTRAS = {
    "landmarks": ("mediapipe", "faces in pictures: video, scans without markers, tracking"),
    "realsense": ("rosbags", "RealSense recordings (.bag)"),
    "record3d": ("lzfse", "Record3D takes (.r3d)"),
    "light": ("cv2", "calibration of active light"),
    "usd": ("pxr", "USD out and in"),
    "alembic": ("alembic3d", "Alembic out"),
    "stream": ("pythonosc", "VMC streams"),
}
"""An extra -> the module that it brings, and what for."""


def require(module: str, extra: str) -> ModuleType:
    """The module, which an extra brings.

    Raises:
        BadInput: it cannot be imported, or a library of the system that it needs cannot.
    """
    try:
        return import_module(module)
    except (ImportError, OSError) as error:
        _, what = EXTRAS[extra]
        raise BadInput(f"{what}: {module} is missing ({error}); pip install 'mien[{extra}]'") from error
