"""Variational optical flow between images of any number of channels."""

from .config import FlowConfig
from .constraints import FlowConstraints, curve_constraints
from .driver import Solved, coarse_to_fine
from .variational import FlowResult, optical_flow, solve_level
from .warp import Level, pyramid, warp

__all__ = [
    "FlowConfig",
    "FlowConstraints",
    "FlowResult",
    "Level",
    "Solved",
    "coarse_to_fine",
    "curve_constraints",
    "optical_flow",
    "pyramid",
    "solve_level",
    "warp",
]
