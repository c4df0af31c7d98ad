"""People who hold expressions before a staged sensor, turning their heads, for textured blendshapes."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ..faces.arkit import ARKIT_NAMES
from ..stage import (
    FilmConfig,
    HeadMotion,
    Performer,
    PerformerConfig,
    Skin,
    SkinConfig,
    StagedFilm,
    film,
    make_performer,
    make_skin,
)

EXPRESSIONS: dict[str, dict[str, float]] = {
    "neutral": {},
    "smile": {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9, "cheekSquintLeft": 0.5, "cheekSquintRight": 0.5},
    "jawOpen": {"jawOpen": 0.7},
    "brows_up": {"browInnerUp": 0.8, "browOuterUpLeft": 0.8, "browOuterUpRight": 0.8},
    "frown": {"browDownLeft": 0.9, "browDownRight": 0.9, "noseSneerLeft": 0.3, "noseSneerRight": 0.3},
    "mouthPucker": {"mouthPucker": 0.9},
    "mouthLeft": {"mouthLeft": 0.9},
    "eyes_closed": {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
}
"""Eight captures: ARKit weights by the capture's name."""


@dataclass(frozen=True)
class CaptureStageConfig:
    """A session before the sensor."""

    frames: int = 30
    """Of each expression."""
    rate: float = 15.0
    sweep: float = 0.6
    """How far the head turns to either side, radians."""
    levels: int = 2
    """Of the skin's subdivision: 2 is about 48,000 vertices; 0 plays the bare performer."""
    film: FilmConfig = field(default_factory=lambda: FilmConfig(head=HeadMotion(rotation=0.02, translation=4.0)))
    person: PerformerConfig = field(default_factory=PerformerConfig)


def capture_actor(seed: int, config: CaptureStageConfig = CaptureStageConfig()) -> Performer | Skin:
    """The person of a session."""
    performer = make_performer(seed, config.person)
    return make_skin(performer, SkinConfig(levels=config.levels), seed) if config.levels else performer


def capture_weights(name: str) -> Float[np.ndarray, " 52"]:
    """ARKit weights of one of `EXPRESSIONS`."""
    weights = np.zeros(len(ARKIT_NAMES))
    for unit, value in EXPRESSIONS[name].items():
        weights[ARKIT_NAMES.index(unit)] = value
    return weights


def staged_capture(
    actor: Performer | Skin, name: str, seed: int, config: CaptureStageConfig = CaptureStageConfig()
) -> StagedFilm:
    """One expression held before the sensor while the head turns from side to side."""
    from dataclasses import replace

    held = np.tile(capture_weights(name), (config.frames, 1))
    settings = replace(config.film, sweep=config.sweep)
    number = list(EXPRESSIONS).index(name)
    return film(actor, held, config.rate, settings, 100 * seed + number)
