"""Blendshape rigs and performances."""

from .performance import Performance
from .rig import Rig

__all__ = ["Performance", "Rig"]
