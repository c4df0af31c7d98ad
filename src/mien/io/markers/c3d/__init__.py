"""C3D marker takes in and out."""

from .read import read_c3d
from .write import Axis, write_c3d

__all__ = ["Axis", "read_c3d", "write_c3d"]
