"""Studies of displacement maps on the stage: other markers, and what the maps weigh (Ma et al. 2008, sec. 4, 5)."""

from collections.abc import Iterator

import numpy as np

from ..detail.base_mesh import BaseConfig, base_mesh
from ..detail.fit import DetailConfig, DetailModel
from ..detail.sampling import interpolated
from ..detail.training import Clip, TrainingSet, aligned_frames
from ..detail.transfer.markers_elsewhere import placed_at
from ..detail.transfer.other_actor import OtherActor, carried_to
from ..mesh import ClosestPoint
from ..rig import Performance, Rig
from ..stage import marker_layout
from ..stage.script.training_clips import expression_clip, unseen_clip
from ..stage.sensors.mocap import markers_on_skin
from ..transforms import Transform
from .detail_stage import RATE, DetailErrors, DetailStage, detail_errors

SHIFTS_MM = (0.0, 1.0, 2.0, 4.0)
"""By how far markers are glued off their training places."""
COUNTS = (60, 100, 178)
"""Markers of a take driven by maps of 178."""
STANDOFF_MM, JITTER_MM = 2.0, 0.02
"""Of the markers, as in `DetailStageConfig`."""


def placement_errors(
    stage: DetailStage, model: DetailModel, base: BaseConfig = BaseConfig()
) -> Iterator[tuple[str, float, float]]:
    """Name, shell's and full error over the held-out clips, mm, for markers shifted or of another number.

    Args:
        model: fitted to the stage's training clips, on a mesh by `base`.
    """
    yield "as trained", *_mean_errors(model, stage.unseen, base)
    rng = np.random.default_rng(1)
    for shift in SHIFTS_MM[1:]:
        yield f"shifted by {shift:g} mm", *_mean_errors(model, _glued(stage, model, rng, shift, None), base)
    for count in COUNTS:
        yield f"{count} other markers", *_mean_errors(model, _glued(stage, model, rng, 0.0, count), base)


def _glued(stage: DetailStage, model: DetailModel, rng, shift: float, count: int | None) -> TrainingSet:
    """The held-out clips as other markers see them: what these carry the training's markers to."""
    skin = stage.skin
    rest = stage.training.markers
    if count is None:
        step = rng.normal(size=rest.shape)
        places = ClosestPoint(skin.neutral).query(rest + shift * step / np.linalg.norm(step, axis=1, keepdims=True))
        attachment = places.attachment()
    else:
        attachment = marker_layout(skin, count, int(rng.integers(1000))).attachment
    standoff = np.full(len(attachment.faces), STANDOFF_MM)
    neutral = markers_on_skin(skin, np.zeros((1, 52)), attachment, standoff)[0]
    placement = placed_at(model, tuple(f"N{i}" for i in range(len(neutral))), neutral)
    clips = []
    for clip in stage.unseen.clips:
        still = markers_on_skin(skin, unseen_clip(clip.name, len(clip.markers), stage.seed), attachment, standoff)
        still = still + JITTER_MM * rng.normal(size=still.shape)
        offset = placement.head.aligned(still) - neutral
        moved = rest + np.einsum("kj,tjd->tkd", placement.carry, offset)
        T = stage.training.head.pose(clip.markers)
        clips.append(Clip(clip.name, T.apply(moved), clip.frames))
    return TrainingSet(stage.unseen.mesh, rest, stage.unseen.labels, tuple(clips))


def _mean_errors(model: DetailModel, clips: TrainingSet, base: BaseConfig) -> tuple[float, float]:
    errors = detail_errors(model, clips, base).values()
    return float(np.mean([e.shell for e in errors])), float(np.mean([e.full for e in errors]))


def reflectance_errors(model: DetailModel, clips: TrainingSet, base: BaseConfig) -> dict[str, tuple[float, float]]:
    """Each clip's mean distance of linear albedo from the true skin's, all of it: constant term alone, whole map.

    Args:
        clips: with colours that no dot is in.
    """
    assert model.reflectance is not None
    grid = model.medium.texels
    on_training = base_mesh(clips.mesh, base).on_training(grid.attachment)
    rest = model.reflectance.polynomial.coefficients[:, -1]
    frames, out = aligned_frames(clips, model.head), {}
    for clip in clips.clips:
        rows = []
        for _ in range(len(clip.markers)):
            aligned = next(frames)
            assert aligned.colors is not None
            truth = interpolated(aligned.colors, on_training, clips.mesh.faces)
            made = model.reflectance.driven.values(model.domain.vectors(aligned.markers[None])[0])
            rows.append([np.linalg.norm(guess - truth, axis=1).mean() for guess in (rest, made)])
        out[clip.name] = tuple(map(float, np.mean(rows, axis=0)))
    return out


def transfer_errors(
    model: DetailModel, other: DetailStage, config: DetailConfig
) -> Iterator[tuple[str, DetailErrors]]:
    """Every clip of another subject under wrinkles carried to it from `model` by its neutral scan alone, mm."""
    actor = OtherActor(other.training.mesh, other.training.markers)
    carried = carried_to(model, actor, config)
    for part in (other.training, other.unseen):
        yield from detail_errors(carried, part, config.base).items()


def staged_performance(stage: DetailStage) -> Performance:
    """All clips one after another, as a rig of the subject's own 52 shapes plays them."""
    performer, config = stage.skin.performer, stage.config
    neutral, count = performer.neutral, len(performer.names)
    rig = Rig(neutral, performer.vertices(np.eye(count)) - neutral.vertices, performer.names)
    seen = [expression_clip(clip.name, config.frames, stage.seed) for clip in stage.training.clips]
    other = [unseen_clip(clip.name, config.unseen_frames, stage.seed) for clip in stage.unseen.clips]
    weights = np.concatenate([*seen, *other])
    frames = len(weights)
    return Performance(rig, weights, Transform.identity(frames), RATE, np.ones(frames, bool))


def storage_bytes(training: TrainingSet, model: DetailModel) -> tuple[int, int, int]:
    """Of the training surfaces (32-bit floats), of both maps with their limits, and of both maps at 16 bits."""
    data = len(training) * training.mesh.vertices.size * 4
    maps = sum(m.polynomial.with_limits().nbytes for m in (model.medium, model.fine) if m is not None)
    return data, maps, maps // 2
