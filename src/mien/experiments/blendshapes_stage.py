"""People who hold expressions before a staged sensor, turning their heads, for textured blendshapes."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from ..camera import Camera
from ..depth import RGBDFrame
from ..faces.arkit import ARKIT_NAMES
from ..mesh import ClosestPoint
from ..stage import (
    DepthSensor,
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
    structured_light,
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
    held = np.tile(capture_weights(name), (config.frames, 1))
    settings = replace(config.film, sweep=config.sweep)
    number = list(EXPRESSIONS).index(name)
    return film(actor, held, config.rate, settings, 100 * seed + number)


@dataclass(frozen=True)
class Grade:
    """A sensor and how far from it people sit."""

    sensor: DepthSensor
    distance: float
    """Mm."""


def _grades() -> dict[str, Grade]:
    """The paper's three sensors (sec. 6), from low to high, by what their makers and tests of them say."""
    kinect = structured_light()
    near = Camera(620.0, 620.0, 319.5, 239.5, 640, 480)
    fine = Camera(760.0, 760.0, 399.5, 299.5, 800, 600)
    f200 = replace(kinect, camera=near, noise=0.6, disparity_step=0.08, baseline=47.0, nearest=200.0)
    structure = replace(kinect, camera=fine, noise=0.5, disparity_step=0.0625, baseline=65.0, nearest=350.0)
    return {"kinect v1": Grade(kinect, 800.0), "f200": Grade(f200, 480.0), "structure": Grade(structure, 520.0)}


GRADES = _grades()
"""Kinect v1, RealSense F200 and Structure Sensor with an iPad's colour."""


def graded(grade: Grade) -> FilmConfig:
    """The film that a grade of sensor makes."""
    return replace(CaptureStageConfig().film, sensor=grade.sensor, distance=grade.distance)


FACE_MM = (40.0, -70.0)
"""Points in front of this depth and above this height in face space are compared."""
FAR_MM = 10.0
"""Points farther from the true surface are not of it."""


def single_frames(staged: StagedFilm, frames: Sequence[RGBDFrame]) -> list[float]:
    """Mean distance of each frame's own points from the true surface, mm, its true pose given."""
    truth, camera = staged.truth, staged.take.camera
    surface = ClosestPoint(truth.actor.mesh(truth.weights[0]))
    found = []
    for i, frame in enumerate(frames):
        assert frame.depth is not None
        rows, columns = np.nonzero(frame.depth > 0)
        rays = camera.rays(np.stack([columns, rows], 1).astype(np.float64))
        seen = rays * frame.depth[rows, columns, None]
        points = truth.T_lab_face[i].inverse().apply(seen)
        face = points[(points[:, 2] > FACE_MM[0]) & (points[:, 1] > FACE_MM[1])]
        off = surface.query(face[:: max(1, len(face) // 3000)]).distances
        found.append(float(off[off < FAR_MM].mean()))
    return found
