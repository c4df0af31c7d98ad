"""Detail maps on the stage: training sets of a staged skin, and how near to it a synthesis comes."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float
from scipy.spatial import KDTree

from ..detail.base_mesh import BaseConfig, base_mesh
from ..detail.fields import DetailMap
from ..detail.fit import DetailModel
from ..detail.sampling import Sampler, interpolated, sampler
from ..detail.texture_space import Texels, sample, with_gutter
from ..detail.training import Aligned, Clip, Frame, TrainingSet, aligned_frames
from ..mesh import Attachment, closest_point
from ..pictures.color import to_linear
from ..stage import STRANGER, HeadMotion, Skin, SkinConfig, make_performer, make_skin, marker_layout
from ..stage.script.training_clips import EXPRESSIONS, UNSEEN, expression_clip, unseen_clip
from ..stage.sensors.mocap import head_motion, markers_on_skin
from ..transforms import Transform

RATE = 30.0
"""Captures a second of the paper's rig."""
FARTHEST_MM = 15.0
"""As `DetailConfig.farthest_mm`: displacements beyond it are no skin."""


GLUED_MM = 1.0
"""Rms by which a marker misses the place that it has on another subject."""
PAINT = 0.02
"""Linear albedo of a dot."""
SCORED = 40_000
"""Points at which a synthesis is held against the truth."""


@dataclass(frozen=True)
class DetailStageConfig:
    """A staged subject before the scanner."""

    kind: Literal["bent", "muscles"] = "muscles"
    """Whose expressions: the bundled shapes bent, or a stranger's muscles."""

    markers: int = 178
    frames: int = 20
    """A training clip."""
    unseen_frames: int = 12
    levels: int = 3
    """Of the skin's subdivision: 3 is about 190,000 vertices, 2 about 49,000."""
    standoff_mm: float = 2.0
    jitter_mm: float = 0.02
    """Of the markers: dots in the scanner's own high-resolution cameras."""
    dot_radius_mm: float | None = None
    """Of the black dots in the colours; 0: colours without dots; None: colours are not photographed."""
    eyes_and_teeth: bool = False
    """In the surfaces, as in registered scans; no map covers them."""
    head: HeadMotion = field(default_factory=lambda: HeadMotion(rotation=0.05, translation=5.0))


@dataclass(frozen=True)
class DetailStage:
    """Clips to learn from and clips to be judged by."""

    training: TrainingSet
    unseen: TrainingSet
    skin: Skin
    attachment: Attachment
    """Of the markers on the skin."""
    seed: int
    config: DetailStageConfig


def detail_stage(
    seed: int, config: DetailStageConfig = DetailStageConfig(), like: DetailStage | None = None
) -> DetailStage:
    """A subject whose wrinkles buckle and whose pores stretch, in six expressions and three clips never trained on.

    Args:
        like: another subject, at whose markers' places this one's are glued, by eye.
    """
    performer = make_performer(seed, STRANGER if config.kind == "muscles" else None)
    skin = make_skin(performer, SkinConfig(levels=config.levels, eyes_and_teeth=config.eyes_and_teeth), seed)
    layout = marker_layout(skin, config.markers, seed)
    rng = np.random.default_rng([seed, 8])
    attachment = layout.attachment if like is None else same_places(like, skin, rng)
    standoff = np.full(config.markers, config.standoff_mm)

    def clip(name: str, weights: Float[np.ndarray, "frames 52"]) -> Clip:
        T = head_motion(len(weights), RATE, config.head, rng)
        still = markers_on_skin(skin, weights, attachment, standoff)
        noise = config.jitter_mm * rng.normal(size=still.shape)
        return Clip(name, T.apply(still) + noise, lambda: _surfaces(skin, weights, T, dots))

    dots = None
    if config.dot_radius_mm is not None:
        dots = under_paint(skin, attachment.points(skin.neutral), config.dot_radius_mm)
    rest = markers_on_skin(skin, np.zeros((1, 52)), attachment, standoff)[0]
    seen = tuple(clip(name, expression_clip(name, config.frames, seed)) for name in EXPRESSIONS)
    other = tuple(clip(name, unseen_clip(name, config.unseen_frames, seed)) for name in UNSEEN)
    training = TrainingSet(skin.neutral, rest, layout.labels, seen)
    unseen = TrainingSet(skin.neutral, rest, layout.labels, other)
    return DetailStage(training, unseen, skin, attachment, seed, config)


def same_places(like: DetailStage, skin: Skin, rng: np.random.Generator) -> Attachment:
    """Where the markers of one subject sit on another, glued by eye: `GLUED_MM` off the same point of the anatomy."""
    on_bundled = like.attachment.matrix(like.skin.neutral) @ like.skin.straight
    places = on_bundled @ skin.performer.neutral.vertices
    aim = places + GLUED_MM / np.sqrt(3) * rng.normal(size=places.shape)
    return closest_point(skin.neutral, aim).attachment()


def under_paint(skin: Skin, places: Float[np.ndarray, "k 3"], radius_mm: float) -> Bool[np.ndarray, " n"]:
    """Vertices that the dots' paint covers."""
    away, _ = KDTree(places).query(skin.neutral.vertices)
    return away < radius_mm


def _surfaces(
    skin: Skin, weights: Float[np.ndarray, "frames 52"], T_lab_face: Transform, dots: Bool[np.ndarray, " n"] | None
) -> Iterator[Frame]:
    for i, frame in enumerate(weights):
        colors = None
        if dots is not None:
            colors = to_linear(skin.colors(frame))
            colors[dots] = PAINT
        yield Frame(T_lab_face[i].apply(skin.vertices(frame[None])[0]), colors)


def kept_in_memory(training: TrainingSet) -> TrainingSet:
    """The same set with its surfaces made once, as 32-bit floats."""
    clips = []
    for clip in training.clips:
        made = []
        for frame in clip.frames():
            colors = None if frame.colors is None else frame.colors.astype(np.float32)
            made.append(Frame(frame.vertices.astype(np.float32), colors))
        clips.append(Clip(clip.name, clip.markers, lambda made=made: iter(made)))
    return TrainingSet(training.mesh, training.markers, training.labels, tuple(clips))


@dataclass(frozen=True)
class DetailErrors:
    """Mean distances from the true skin to a synthesis, point by point, mm; reliable texels alone."""

    frozen: float
    """The thin shell with the neutral's static maps."""
    shell: float
    medium: float
    full: float
    """Medium and fine."""

    def line(self) -> str:
        """For a table."""
        return f"{self.frozen:8.4f} {self.shell:8.4f} {self.medium:8.4f} {self.full:8.4f}"


def detail_errors(model: DetailModel, clips: TrainingSet, base: BaseConfig = BaseConfig()) -> dict[str, DetailErrors]:
    """Each clip's errors, by true correspondence: the synthesis's texel against the skin's own point."""
    grid = scoring_points(model, clips, base)
    counts = [(clip.name, len(clip.markers)) for clip in clips.clips]
    frames, out = aligned_frames(clips, model.head), {}
    rest = np.zeros((len(model.reference), 5))
    static = layers(model, grid, rest)
    for name, count in counts:
        rows = [_errors(model, grid, next(frames), static) for _ in range(count)]
        out[name] = DetailErrors(*np.mean(rows, axis=0))
    return out


def scoring_points(model: DetailModel, clips: TrainingSet, base: BaseConfig) -> Sampler:
    """Texels of the finest map, thinned to about `SCORED`: at the medium map's own its aliases would go unseen."""
    finest = model.medium if model.fine is None else model.fine
    grid = sampler(clips, base_mesh(clips.mesh, base), model.shell, finest.texels.size, FARTHEST_MM)
    step = max(1, len(grid.texels.pixels) // SCORED)
    texels = Texels(finest.texels.size, grid.texels.pixels[::step], thinned(grid.texels.attachment, step))
    return replace(grid, texels=texels, on_training=thinned(grid.on_training, step))


def thinned(points: Attachment, step: int) -> Attachment:
    """Every so many of them."""
    return Attachment(points.faces[::step], points.barycentric[::step])


def layers(model: DetailModel, grid: Sampler, vectors: Float[np.ndarray, "k 5"]) -> tuple[np.ndarray, np.ndarray]:
    """Local displacements at a grid's texels: the medium map alone, and with the fine map, (p, 3) each, mm."""
    assert model.base.uv is not None
    uv = interpolated(model.base.uv, grid.texels.attachment, model.base.faces)
    medium = sample(with_gutter(evaluated(model.medium, vectors)), uv)
    full = medium.copy()
    if model.fine is not None:
        full[:, 2] += sample(with_gutter(evaluated(model.fine, vectors)), uv)[:, 0]
    return medium, full


def evaluated(detail: DetailMap, vectors: Float[np.ndarray, "k 5"]) -> Float[np.ndarray, "size size c"]:
    """A map's image in one frame, mm; NaN off the surface."""
    values = detail.driven.values(vectors)
    return detail.texels.image(values.astype(float))


def _errors(model: DetailModel, grid: Sampler, aligned: Aligned, static: tuple[np.ndarray, np.ndarray]) -> list[float]:
    truth = grid.displacement(aligned)
    vectors = model.domain.vectors(aligned.markers[None])[0]
    medium, full = layers(model, grid, vectors)
    marked = model.medium.texels.image(model.medium.unreliable.astype(float))
    assert model.base.uv is not None
    uv = interpolated(model.base.uv, grid.texels.attachment, model.base.faces)
    good = (sample(with_gutter(marked), uv) < 0.5) & np.isfinite(truth).all(axis=1)
    guesses = (static[1], np.zeros_like(truth), medium, full)
    return [float(np.linalg.norm((guess - truth)[good], axis=1).mean()) for guess in guesses]
