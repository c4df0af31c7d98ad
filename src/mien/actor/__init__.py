"""The synthetic stage: a performer, what they perform, sensors with their faults, and the truth to score against."""

from .casting import PerformerConfig, make_performer
from .film import FilmConfig, StagedFilm, film
from .layout import Layout, marker_layout
from .mocap import HeadMotion, MocapConfig, StagedTake, perform
from .performer import Performer
from .scanner import ScanConfig, StagedScan, scan
from .score import Score, score_performance, score_vertices
from .script import Script, frozen, random_performance, scripted
from .sensors import DepthSensor, structured_light, time_of_flight
from .skin import Skin, SkinConfig, make_skin
from .style import StyleConfig
from .truth import Truth

__all__ = [
    "DepthSensor",
    "FilmConfig",
    "HeadMotion",
    "Layout",
    "MocapConfig",
    "Performer",
    "PerformerConfig",
    "ScanConfig",
    "Score",
    "Script",
    "Skin",
    "SkinConfig",
    "StagedFilm",
    "StagedScan",
    "StagedTake",
    "StyleConfig",
    "Truth",
    "film",
    "frozen",
    "make_performer",
    "make_skin",
    "marker_layout",
    "perform",
    "random_performance",
    "scan",
    "score_performance",
    "score_vertices",
    "scripted",
    "structured_light",
    "time_of_flight",
]
