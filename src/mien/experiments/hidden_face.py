"""Figure 10 of Casas et al. 2016 on the stage: a headset hides the upper face, strain gauges in its lining tell it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from ..camera import Camera
from ..depth import RGBDFrame
from ..faces.arkit import ARKIT_NAMES
from ..faces.bundled import load_face
from ..io.gauge_file import GaugeTable
from ..progress import SILENT, Progress
from ..rig import Performance, Rig
from ..stage import (
    FilmConfig,
    HeadMotion,
    Performer,
    Skin,
    StagedFilm,
    Truth,
    film,
    random_performance,
    score_performance,
    structured_light,
)
from ..stage.script.script import ramp
from ..stage.sensors.strain_gauges import GaugeConfig, strain_readings
from ..tracking.hidden.gauge_regression import GaugeRegression, drive_upper, learn_gauges
from ..tracking.hidden.lower_face import upper_shapes
from ..tracking.person.personalize import personalize
from ..tracking.pipeline import TrackTakeConfig, track_take

EVERY = 2
"""Scripts are written at so many times the films' rate."""
CALIBRATION: tuple[dict[str, float], ...] = (
    {"browInnerUp": 1.0, "browOuterUpLeft": 1.0, "browOuterUpRight": 1.0},
    {"browDownLeft": 1.0, "browDownRight": 1.0},
    {"eyeBlinkLeft": 1.0, "eyeBlinkRight": 1.0},
    {"eyeSquintLeft": 1.0, "eyeSquintRight": 1.0},
    {"eyeWideLeft": 1.0, "eyeWideRight": 1.0},
    {"cheekSquintLeft": 1.0, "cheekSquintRight": 1.0, "mouthSmileLeft": 0.8, "mouthSmileRight": 0.8},
    {"browInnerUp": 1.0, "jawOpen": 0.4},
    {"browOuterUpLeft": 1.0, "eyeBlinkRight": 1.0},
    {"browOuterUpRight": 1.0, "eyeBlinkLeft": 1.0},
    {"jawOpen": 0.8},
    {"mouthPucker": 0.9},
)
"""What is played, all of the face in view, one after the other and again: upper shapes, and mouths without them."""

GAZE = "eyeLook"
"""Shapes that no gauge on the skin can tell begin so; they are not scored."""


@dataclass(frozen=True)
class HiddenFaceConfig:
    """A session: the whole face is filmed first, then the headset is put on."""

    calm: int = 16
    """Frames at rest at the beginning of either film."""
    each_s: float = 0.8
    """How long an expression of the calibration takes."""
    times: int = 2
    """How often each comes."""
    seconds: float = 6.0
    """Of the take with the headset."""
    poses: tuple[Mapping[str, float], ...] = ()
    """What is played in it, one after the other, each as long as one of the calibration; none: what comes by chance."""
    rate: float = 15.0
    gauges: GaugeConfig = GaugeConfig()
    film: FilmConfig = field(
        default_factory=lambda: FilmConfig(
            sensor=replace(structured_light(), camera=Camera(310.0, 310.0, 159.5, 119.5, 320, 240), nearest=250.0),
            distance=450.0,
            head=HeadMotion(rotation=0.04, translation=5.0),
        )
    )
    """A small sensor near the face, as one on a headset's arm is."""


@dataclass(frozen=True)
class HiddenFace:
    """What came of a session."""

    frames: Sequence[RGBDFrame]
    """With the headset on."""
    truth: Truth
    lower: Performance
    """Tracked from what is seen, upper shapes at rest."""
    driven: Performance
    """With the upper shapes that the gauges tell."""
    calibration: Performance
    regression: GaugeRegression


def hidden_face(
    actor: Performer | Skin,
    seed: int,
    config: HiddenFaceConfig = HiddenFaceConfig(),
    progress: Progress = SILENT,
    rig: Rig | None = None,
) -> HiddenFace:
    """Film both takes, calibrate on the first, track the second and drive its upper face.

    rig: the actor's, of the ARKit shapes; None: the first take is personalised.
    """
    seen = _filmed(actor, in_turn(CALIBRATION * config.times, config), 2 * seed, config.film, config)
    played = random_performance(EVERY * config.rate, config.seconds, seed).weights[::EVERY]
    if config.poses:
        played = in_turn(config.poses, config)
    worn = _filmed(actor, played, 2 * seed + 1, replace(config.film, worn=("headset",)), config)
    frames, hidden = list(seen.take), list(worn.take)
    whole = replace(seen.take, frames=lambda: iter(frames))
    landmarks = None
    if rig is None:
        person = personalize(whole, progress=progress)
        rig, landmarks = person.rig, person.landmarks
    calibration = track_take(whole, rig, landmarks, progress=progress).performance
    gauges = [_table(staged.truth, config, 2 * seed + i) for i, staged in enumerate((seen, worn))]
    regression = learn_gauges(calibration, *gauges)
    take = replace(worn.take, frames=lambda: iter(hidden))
    found = track_take(take, rig, landmarks, config=TrackTakeConfig(hidden="upper"), progress=progress)
    driven = drive_upper(found.performance, regression, gauges[1])
    return HiddenFace(hidden, worn.truth, found.performance, driven, calibration, regression)


def hidden_errors(found: HiddenFace) -> dict[str, dict[str, float]]:
    """Rms distance of upper and of lower shapes' weights from the true ones, of zeros and of a mean face."""
    upper = upper_shapes(ARKIT_NAMES)
    named = list(zip(ARKIT_NAMES, upper, strict=True))
    parts = {
        "upper": [name for name, there in named if there and not name.startswith(GAZE)],
        "lower": [name for name, there in named if not there],
    }
    return {part: weight_errors(found.truth, found.driven, found.calibration, names) for part, names in parts.items()}


def lower_skin(found: HiddenFace) -> tuple[float, float]:
    """How far skin of the lower face is moved wrongly, mean, mm; and in a face that holds the mean expression."""
    score = score_performance(found.driven, found.truth, load_face().regions["lower"], EVERY)
    return float(score.expression.mean()), float(score.frozen.mean())


def moments(found: HiddenFace, count: int) -> list[int]:
    """The frame of most expression in each of so many parts of the take, without the calm at its beginning."""
    strength = found.truth.weights.sum(1)
    moving = np.arange(np.flatnonzero(strength > 0).min(initial=len(strength) - count), len(strength))
    return [int(part[strength[part].argmax()]) for part in np.array_split(moving, count)]


def weight_errors(
    truth: Truth, driven: Performance, calibration: Performance, names: Sequence[str]
) -> dict[str, float]:
    """Rms distance of some shapes' weights from the true ones: of ours, of zeros, of the calibration's mean."""
    true = truth.weights[:, [ARKIT_NAMES.index(name) for name in names]]
    ways = {
        "ours": _columns(driven, names),
        "zeros": np.zeros_like(true),
        "frozen": np.broadcast_to(_columns(calibration, names).mean(0), true.shape),
    }
    return {way: float(np.sqrt(((weights - true) ** 2).mean())) for way, weights in ways.items()}


def in_turn(poses: Sequence[Mapping[str, float]], config: HiddenFaceConfig) -> Float[np.ndarray, "frames 52"]:
    """Expressions one after the other, each rising, held and falling."""
    frames = round(config.each_s * config.rate)
    share = np.arange(frames) / frames
    bump = ramp(share, 0.0, 0.25, 0.4, 0.25)
    weights = [[pose.get(name, 0.0) for name in ARKIT_NAMES] for pose in poses]
    return np.concatenate([np.outer(bump, pose) for pose in weights])


def _filmed(actor, played, seed: int, film_config: FilmConfig, config: HiddenFaceConfig) -> StagedFilm:
    calm = np.zeros((config.calm, played.shape[1]))
    return film(actor, np.concatenate([calm, played]), config.rate, film_config, seed)


def _table(truth: Truth, config: HiddenFaceConfig, seed: int) -> GaugeTable:
    readings = strain_readings(truth, config.gauges, seed)
    return GaugeTable(f"gauges of take {seed}", readings.times, readings.names, readings.values)


def _columns(performance: Performance, names: Sequence[str]) -> Float[np.ndarray, "frames shapes"]:
    return performance.weights[:, [performance.rig.index(name) for name in names]]
