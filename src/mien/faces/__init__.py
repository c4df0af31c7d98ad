"""Faces: the bundled head and its identity space, ICT-FaceKit's, landmark detection."""

from .arkit import ARKIT_NAMES
from .bundled import BundledFace, IdentitySpace, load_face

__all__ = ["ARKIT_NAMES", "BundledFace", "IdentitySpace", "load_face"]
