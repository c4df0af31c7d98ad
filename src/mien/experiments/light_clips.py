"""Clips of a dotted face under active light on the stage, and how near the scans and the wrinkles learnt come to it."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from PIL import Image

from ..detail.fit import DetailModel
from ..detail.training import Aligned, TrainingSet
from ..light.light_rig import write_rig
from ..light.patterns import write_patterns
from ..light.pipeline import LightConfig, moment
from ..mesh import ClosestPoint, Mesh
from ..progress import SILENT, Progress
from ..stage import Skin
from ..stage.script.training_clips import EXPRESSIONS, expression_clip, unseen_clip
from ..stage.sensors.active_light import ActiveLightConfig
from ..transforms import Transform
from .detail_figures import shown_mesh, synthesized
from .light_stage import LightStageConfig, StagedCapture, front_centre, staged_capture

NEUTRAL = "neutral"
SCORED = 4000
"""Points of a surface at which it is held against the truth."""


@dataclass(frozen=True)
class LightClipsConfig:
    """What is played before the rig."""

    stage: LightStageConfig = LightStageConfig(
        size=(384, 512), projector=(512, 384), dots=178, faults=ActiveLightConfig(bits=8)
    )
    clips: dict[str, int] = field(default_factory=lambda: {"anger": 6, "asymmetric": 4, "disgust": 5, "happy": 6})
    """Captures of each clip, neutral to extreme."""
    unseen: tuple[str, ...] = ("asymmetric",)
    """Clips that nothing is learnt from."""
    capture_share: float = 0.15
    """How far a face goes within one capture, of the way to the next: the paper's rig takes 30 a second."""
    sway_mm: float = 0.3
    """How far the head goes in that time."""


def staged_captures(skin: Skin, name: str, count: int, config: LightClipsConfig, seed: int) -> Iterator[StagedCapture]:
    """A clip's captures, one by one; the neutral holds still."""
    stage = replace(config.stage, centre=tuple(front_centre(skin.neutral.vertices)))
    if name == NEUTRAL:
        rest = np.zeros(len(skin.names))
        yield staged_capture(skin, rest, rest, stage, seed=seed)
        return
    weights = (expression_clip if name in EXPRESSIONS else unseen_clip)(name, count, seed)
    ahead = np.concatenate([weights[1:], weights[-1:]])
    for number in range(count):
        end = weights[number] + config.capture_share * (ahead[number] - weights[number])
        sway = config.sway_mm * np.array([1.0, 0.5, 0.3]) * np.cos(number)
        yield staged_capture(skin, weights[number], end, stage, move_mm=tuple(sway), seed=1000 * seed + number)


def write_staged_takes(
    folder: Path, skin: Skin, config: LightClipsConfig = LightClipsConfig(), seed: int = 0, progress: Progress = SILENT
) -> dict[str, list[Mesh]]:
    """`CLIP/left/000.png`, ... as a rig would leave them; gives back the true skin of each capture, rig space, mm."""
    plan = {NEUTRAL: 1} | config.clips
    truth, done = {}, 0
    for name, count in plan.items():
        truth[name] = []
        for number, capture in enumerate(staged_captures(skin, name, count, config, seed)):
            write_capture(folder, name, number, capture)
            truth[name].append(capture.truth(moment(capture.patterns, LightConfig().motion)))
            done += 1
            progress.update("staging captures", done, sum(plan.values()))
    return truth


def write_capture(folder: Path, clip: str, number: int, capture: StagedCapture) -> None:
    """One capture's pictures, and beside the clips what they share: patterns and calibration."""
    for view, images in capture.images.items():
        place = folder / clip / view
        place.mkdir(parents=True, exist_ok=True)
        for slot, image in enumerate(images):
            stored = np.round(255 * image).astype(np.uint8)
            Image.fromarray(stored).save(place / f"{number * len(images) + slot:04d}.png", compress_level=1)
    write_patterns(folder / "patterns.json", capture.patterns)
    write_rig(folder / "calibration.json", capture.rig)


@dataclass(frozen=True)
class ChainErrors:
    """Mean distances from the true skin in a clip's last frame, mm."""

    scan: float
    """Of the decoded scan, in the common texture space."""
    again: float
    """Of its points from the very same points of the true skin."""
    shell: float
    """Of the markers' thin shell alone."""
    full: float
    """Of the synthesis, from the dots alone."""


def chain_errors(
    model: DetailModel, clips: TrainingSet, truth: dict[str, list[Mesh]], T_face_rig: Transform
) -> dict[str, ChainErrors]:
    """Scans and synthesis against what was really there, clip by clip."""
    at_rest = ClosestPoint(_in_face(truth[NEUTRAL][0], T_face_rig)).query(clips.mesh.vertices).attachment()
    out = {}
    for clip in clips.clips:
        *_, frame = clip.frames()
        true = _in_face(truth[clip.name][-1], T_face_rig)
        surface = ClosestPoint(true)
        vertices = np.asarray(frame.vertices, float)
        seen = np.flatnonzero(np.isfinite(vertices).all(axis=1))
        some = seen[:: max(1, len(seen) // SCORED)]
        again = np.linalg.norm(vertices[some] - at_rest.points(true)[some], axis=1)
        T = model.head.pose(clip.markers[-1:])[0]
        aligned = Aligned(T.inverse().apply(clip.markers[-1]), T.inverse().apply(vertices), None)
        shown = ClosestPoint(shown_mesh(aligned.vertices, clips.mesh.faces))
        layers = [_distance(synthesized(model, aligned, on, on), T, surface, shown) for on in (False, True)]
        out[clip.name] = ChainErrors(surface.query(vertices[some]).distances.mean(), again.mean(), *layers)
    return out


def _in_face(mesh: Mesh, T_face_rig: Transform) -> Mesh:
    return Mesh(T_face_rig.apply(mesh.vertices), mesh.faces)


def _distance(made: Mesh, T_lab_face: Transform, truth: ClosestPoint, shown: ClosestPoint) -> float:
    """Mean distance of a synthesis from the truth, where the scan shows skin."""
    some = made.vertices[:: max(1, len(made.vertices) // SCORED)]
    near = shown.query(some).distances < SEEN_MM
    return float(truth.query(T_lab_face.apply(some[near])).distances.mean())


SEEN_MM = 4.0
"""Synthesised skin farther than this from the scan lies where the camera saw none."""
