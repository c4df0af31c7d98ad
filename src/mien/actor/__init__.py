"""The synthetic stage: a performer, what they perform, sensors with their faults, and the truth to score against."""

from .casting import PerformerConfig, make_performer
from .layout import Layout, marker_layout
from .mocap import HeadMotion, MocapConfig, StagedTake, Truth, perform
from .performer import Performer
from .score import Score, score_performance, score_vertices
from .script import Script, frozen, random_performance, scripted
from .style import StyleConfig

__all__ = [
    "HeadMotion",
    "Layout",
    "MocapConfig",
    "Performer",
    "PerformerConfig",
    "Score",
    "Script",
    "StagedTake",
    "StyleConfig",
    "Truth",
    "frozen",
    "make_performer",
    "marker_layout",
    "perform",
    "random_performance",
    "score_performance",
    "score_vertices",
    "scripted",
]
