"""Faces: the bundled head and its identity space, ICT-FaceKit's."""

from .arkit import ARKIT_NAMES
from .bundled import BundledFace, IdentitySpace, load_face
from .ict import load_ict

__all__ = ["ARKIT_NAMES", "BundledFace", "IdentitySpace", "load_face", "load_ict"]
