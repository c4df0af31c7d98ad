"""The synthetic stage: a performer, what they perform, sensors with their faults, and the truth to score against."""

from .people.make_performer import STRANGER, PerformerConfig, make_performer
from .people.performer import Performer
from .people.skin import Skin, SkinConfig, make_skin
from .people.style import StyleConfig
from .rank_correlation import rank_correlation
from .score import Score, score_performance, score_vertices
from .script.script import Script, frozen, random_performance, scripted
from .sensors.depth_sensor import DepthSensor, structured_light, time_of_flight
from .sensors.film import HARD_FILM, FilmConfig, StagedFilm, film
from .sensors.marker_layout import MarkerLayout, marker_layout
from .sensors.mocap import HARD_MOCAP, HeadMotion, MocapConfig, StagedTake, perform
from .sensors.scanner import HARD_SCAN, ScanConfig, StagedScan, scan
from .truth import Truth

__all__ = [
    "HARD_FILM",
    "HARD_MOCAP",
    "HARD_SCAN",
    "STRANGER",
    "DepthSensor",
    "FilmConfig",
    "HeadMotion",
    "MarkerLayout",
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
    "rank_correlation",
    "scan",
    "score_performance",
    "score_vertices",
    "scripted",
    "structured_light",
    "time_of_flight",
]
