"""A tracked take says what its rig's shapes miss: what the final mesh adds to them, and how skin slips along it."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np
from jaxtyping import Float, Float32, Int

from ...image_space.layout import sampled
from ...progress import SILENT, Progress
from ...rgbd import RgbdTake
from ...rig import Performance, Rig
from ...transforms import Transform
from ..model import TrackingModel
from .front_chart import ChartedFrame, FrontChart, charted, front_chart
from .node_grid import NodeGrid
from .shape_corrections import (
    BLOCKS,
    CorrectionConfig,
    MissedMotion,
    along_corrections,
    believed_corrections,
    nothing_missed,
)
from .shape_flow import ShapeFlowConfig, difference, shape_flow
from .skin_look import LookConfig, calm_reference, normalised

CALM_SHARE = 0.25
"""At most this share of a take's tracked frames counts as calm."""
TINY = 1e-9
"""Pictures that differ by less do not differ."""


@dataclass(frozen=True)
class RelearnConfig:
    """Shapes relearnt from the picture after a first pass; the take is then tracked anew."""

    rounds: int = 2
    """How often. A third brings half of what the second does."""
    frames: int = 200
    """Most frames whose final mesh is looked at, evenly over the take; 0 = none: the rig's shapes stay as they are."""
    pictures: int = 30
    """Most of them whose picture is looked at, a quarter of a second of processor time each. More say nothing new: what
    errs is not noise, but what skin looks like in an expression."""
    least: int = 60
    """A take of fewer tracked frames says too little."""
    calm: int = 30
    """Most frames, those with the least expression, that show what the skin looks like at rest."""
    look: LookConfig = field(default_factory=LookConfig)
    flow: ShapeFlowConfig = field(default_factory=ShapeFlowConfig)
    corrections: CorrectionConfig = field(default_factory=CorrectionConfig)


@dataclass(frozen=True)
class FirstPass:
    """A take and how it was tracked."""

    take: RgbdTake
    model: TrackingModel
    performance: Performance
    fitted: Float[np.ndarray, "frames k"]
    """Weights of the blendshape fit."""
    T_world_camera: Transform
    """The performance's world from the take's camera."""

    def charted(self, chart: FrontChart, numbers: Int[np.ndarray, " n"]) -> Iterator[tuple[int, ChartedFrame]]:
        """Frames of the take on the chart, in their order, as they are read; those without a picture are left out."""
        wanted = set(numbers.tolist())
        T_camera_face = self.T_world_camera.inverse() @ self.performance.T_world_face
        for number, frame in enumerate(islice(iter(self.take), int(numbers.max()) + 1)):
            if number in wanted and frame.color is not None:
                T, camera = T_camera_face[number], self.take.camera
                yield number, charted(chart, frame.color, frame.depth, camera, T, self.front(number))

    def front(self, number: int) -> Float[np.ndarray, "f 3"]:
        """The front as it was tracked, face space, mm."""
        return self.performance.rig.vertices(self.performance.weights[number])[self.model.front]

    def offset(self, number: int) -> Float32[np.ndarray, "f 3"]:
        """What the final mesh adds to the shapes, mm."""
        return (self.front(number) - self.model.blend(self.fitted[number])).astype(np.float32)


def relearn_shapes(first: FirstPass, config: RelearnConfig = RelearnConfig(), progress: Progress = SILENT) -> Rig:
    """The model's rig, its shapes corrected by the motion of the skin that they missed; the same rig if there is none.

    Across the skin the depth tells it, as the final mesh does. Along the skin depth shows nothing, and the landmarks
    little: a shape that pulls a cheek up where this person pulls it back fits the depth all the same. The picture shows
    it. Both are noisy frame by frame, but what comes back with the weights is the shapes' own.
    """
    tracked = np.flatnonzero(first.performance.tracked)
    if not config.frames or len(tracked) < config.least:
        return first.model.rig
    numbers = calm_numbers(first, tracked, min(config.calm, int(CALM_SHARE * len(tracked))))
    calm = calm_look(first, numbers, config.look)
    if calm is None:
        return first.model.rig
    across = missed_by_mesh(first, calm, evenly(tracked, config.frames))
    found = believed_corrections(across, first.model, config.corrections)
    found += missed_along(first, calm, evenly(tracked, config.pictures), config, progress)
    return bent_rig(first.model, found) if found.any() else first.model.rig


def evenly(numbers: Int[np.ndarray, " n"], most: int) -> Int[np.ndarray, " m"]:
    """At most so many of them, evenly."""
    return numbers[:: -(-len(numbers) // most)]


def calm_numbers(first: FirstPass, tracked: Int[np.ndarray, " n"], most: int) -> Int[np.ndarray, " c"]:
    """The tracked frames in which the fitted shapes move the front least."""
    basis = first.model.basis.astype(np.float64)
    gram = np.einsum("f,fdk,fdl->kl", first.model.share, basis, basis, optimize=True)
    weights = first.fitted[tracked]
    motion = np.einsum("tk,kl,tl->t", weights, gram, weights, optimize=True)
    return np.sort(tracked[np.argsort(motion, kind="stable")[:most]])


@dataclass(frozen=True)
class CalmLook:
    """The face at rest: what other frames are compared with."""

    chart: FrontChart
    reference: Float32[np.ndarray, "h w"]
    """What the skin shows."""
    weights: Float[np.ndarray, " k"]
    """What the fit's are there."""
    offset: Float32[np.ndarray, "f 3"]
    """What the final mesh adds there, mm."""


def calm_look(first: FirstPass, calm: Int[np.ndarray, " c"], config: LookConfig) -> CalmLook | None:
    """What calm frames show; None where they have no picture, or nothing on it."""
    chart = front_chart(first.model, config.pixel_mm)
    frames = [frame for _, frame in first.charted(chart, calm)]
    if not frames:
        return None
    reference = calm_reference(frames, config)
    if not np.isfinite(reference).any():
        return None
    offset = np.mean([first.offset(number) for number in calm.tolist()], axis=0)
    return CalmLook(chart, reference, first.fitted[calm].mean(axis=0), offset)


def missed_by_mesh(first: FirstPass, calm: CalmLook, looked: Int[np.ndarray, " n"]) -> MissedMotion:
    """What the final mesh adds to the shapes, from the face at rest."""
    missed = nothing_missed(first.model.shapes, len(first.model.front))
    for place, number in enumerate(looked.tolist()):
        block = place * BLOCKS // len(looked)
        missed.add(block, first.fitted[number], first.offset(number) - calm.offset)
    return missed


def missed_along(
    first: FirstPass, calm: CalmLook, looked: Int[np.ndarray, " n"], config: RelearnConfig, progress: Progress
) -> Float[np.ndarray, "k f 3"]:
    """What shapes lack along the skin, by the picture, mm at weight 1; 0 where pictures hardly come to agree by it."""
    numbers, pictures, surfaces = [], [], []
    for number, frame in first.charted(calm.chart, looked):
        numbers.append(number)
        pictures.append(normalised(frame.grey, config.look))
        surfaces.append(frame.surface)
        progress.update("looking where skin slips", len(numbers), len(looked))
    weights = first.fitted[numbers] - calm.weights
    found = shape_flow(pictures, calm.reference, weights, config.flow)
    slip = np.stack([slip_of(calm.chart, surface, found.of_frame(t)) for t, surface in enumerate(surfaces)])
    before, after = (
        difference(flow, pictures, calm.reference, config.flow)
        for flow in (replace(found, flow=np.zeros_like(found.flow)), found)
    )
    belief = calm.chart.at_vertices(picture_belief(found.grid, before, after, config))[:, 0]
    return along_corrections(weights, slip, belief, first.model, config.corrections)


def slip_of(
    chart: FrontChart, surface: Float[np.ndarray, "h w 3"], flow: Float32[np.ndarray, "2 h w"]
) -> Float[np.ndarray, "f 3"]:
    """From where the model puts each vertex to where its skin is seen, mm along the surface; 0 off the chart."""
    moved = chart.uv + chart.at_vertices(flow)
    step = sampled(surface, moved) - sampled(surface, chart.uv)
    return step * chart.shown[:, None]


def picture_belief(
    grid: NodeGrid, before: Float[np.ndarray, " n"], after: Float[np.ndarray, " n"], config: RelearnConfig
) -> Float32[np.ndarray, "1 h w"]:
    """0..1: how far flow is believed, by how much nearer it brings the pictures to the reference round about."""
    sigma = config.corrections.around_mm / config.look.pixel_mm
    differs, still = grid.pooled(np.stack([before, after], axis=1), sigma).T
    fall = 1 - still / np.maximum(differs, TINY)
    doubtful, believed = config.corrections.falls_doubtful, config.corrections.falls_believed
    belief = np.clip((fall - doubtful) / (believed - doubtful), 0.0, 1.0)
    return grid.between(belief[:, None])


def bent_rig(model: TrackingModel, corrections: Float[np.ndarray, "k f 3"]) -> Rig:
    """The rig with the front of its shapes corrected."""
    deltas = model.rig.deltas.copy()
    deltas[:, model.front] += corrections
    return replace(model.rig, deltas=deltas)
