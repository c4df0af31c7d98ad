"""A tracked take says what its rig's shapes miss: what the final mesh adds to them, and how skin slips along it."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np
from jaxtyping import Float, Float32, Int

from ...progress import SILENT, Progress
from ...rgbd import RgbdTake
from ...rig import Performance, Rig
from ...transforms import Transform
from ..model import TrackingModel
from .front_chart import ChartedFrame, FrontChart, charted, front_chart
from .shape_corrections import BLOCKS, CorrectionConfig, MissedMotion, believed_corrections, nothing_missed
from .skin_slip import SlipConfig, calm_reference, skin_slip

CALM_SHARE = 0.25
"""At most this share of a take's tracked frames counts as calm."""


@dataclass(frozen=True)
class RelearnConfig:
    """Shapes relearnt from the picture after a first pass; the take is then tracked anew."""

    frames: int = 200
    """Most frames that are looked at, evenly over the take, a quarter of a second of processor time each; 0 = none: the
    rig's shapes stay as they are."""
    least: int = 60
    """A take of fewer tracked frames says too little."""
    calm: int = 30
    """Most frames, those with the least expression, that show what the skin looks like at rest."""
    slip: SlipConfig = field(default_factory=SlipConfig)
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
    calm = calm_look(first, numbers, config.slip)
    if calm is None:
        return first.model.rig
    looked = tracked[:: -(-len(tracked) // config.frames)]
    along, across = missed_motion(first, calm, looked, config.slip, progress)
    found = believed_corrections(along, first.model, config.corrections)
    found += believed_corrections(across, first.model, config.corrections)
    return bent_rig(first.model, found) if found.any() else first.model.rig


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
    slip: Float32[np.ndarray, "f 3"]
    """Slip that stands there, mm."""
    offset: Float32[np.ndarray, "f 3"]
    """What the final mesh adds there, mm."""


def calm_look(first: FirstPass, calm: Int[np.ndarray, " c"], config: SlipConfig) -> CalmLook | None:
    """What calm frames show; None where they have no picture."""
    chart = front_chart(first.model, config.pixel_mm)
    frames = [frame for _, frame in first.charted(chart, calm)]
    if not frames:
        return None
    reference = calm_reference(frames, config)
    slip = np.mean([skin_slip(chart, frame, reference, config) for frame in frames], axis=0)
    offset = np.mean([first.offset(number) for number in calm.tolist()], axis=0)
    return CalmLook(chart, reference, slip, offset)


def missed_motion(
    first: FirstPass, calm: CalmLook, looked: Int[np.ndarray, " n"], config: SlipConfig, progress: Progress
) -> tuple[MissedMotion, MissedMotion]:
    """Along the skin by the picture, and by the final mesh; of the frames looked at, from the face at rest."""
    shapes, vertices = first.model.shapes, len(first.model.front)
    along, across = nothing_missed(shapes, vertices), nothing_missed(shapes, vertices)
    for done, (number, frame) in enumerate(first.charted(calm.chart, looked)):
        block = int(np.searchsorted(looked, number)) * BLOCKS // len(looked)
        weights = first.fitted[number]
        along.add(block, weights, skin_slip(calm.chart, frame, calm.reference, config) - calm.slip)
        across.add(block, weights, first.offset(number) - calm.offset)
        progress.update("looking where skin slips", done + 1, len(looked))
    return along, across


def bent_rig(model: TrackingModel, corrections: Float[np.ndarray, "k f 3"]) -> Rig:
    """The rig with the front of its shapes corrected."""
    deltas = model.rig.deltas.copy()
    deltas[:, model.front] += corrections
    return replace(model.rig, deltas=deltas)
