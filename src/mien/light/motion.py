"""What moves between the slots of one capture, brought to one moment (Wenger et al. 2005; sec. 3)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from ..flow import FlowConfig, optical_flow
from .patterns import PatternSet


@dataclass(frozen=True)
class MotionConfig:
    """How motion within a capture is taken out."""

    compensate: bool = True
    """Warp the gradient conditions to one moment."""
    to_structured: bool = True
    """To the moment of the structured light, whose depth then needs no moving. False: to the tracking slot, as in the
    paper, while the geometry stays where it was."""
    shrink: int = 2
    """The flow is found on pictures so many times smaller: skin moves smoothly."""
    still_px: float = 0.05
    """A median flow below this is noise: nothing is moved."""
    flow: FlowConfig = FlowConfig()


def slot_flow(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, config: MotionConfig = MotionConfig()
) -> Float[np.ndarray, "h w 2"]:
    """How far back each pixel of the tracking slot was one slot earlier, pixels.

    Flow from the tracking frame to the constant condition, which are lit alike, divided by the slots between: motion
    within a capture is taken for even.
    """
    first, last = patterns.one("constant"), patterns.one("tracking")
    pair = [
        ndimage.gaussian_filter(images[slot], config.shrink / 2)[:: config.shrink, :: config.shrink]
        for slot in (last, first)
    ]
    bright = max(float(np.quantile(pair[0], 0.99)), 1e-6)
    found = optical_flow(pair[0] / bright, pair[1] / bright, config=config.flow).flow
    lit = pair[0] > 0.05 * bright
    if not lit.any() or np.median(np.linalg.norm(found[lit], axis=-1)) * config.shrink < config.still_px:
        return np.zeros((*images.shape[1:], 2))
    zoom = [size / small for size, small in zip(images.shape[1:], found.shape[:2], strict=True)]
    large = ndimage.zoom(found, [*zoom, 1], order=1, grid_mode=True, mode="nearest")
    return config.shrink * np.asarray(large) / (last - first)


def at_slot(
    image: Float[np.ndarray, "h w"], flow: Float[np.ndarray, "h w 2"], slots_earlier: float
) -> Float[np.ndarray, "h w"]:
    """A picture taken so many slots before a moment, as if taken at it."""
    if not flow.any():
        return image
    y, x = np.mgrid[: image.shape[0], : image.shape[1]].astype(float)
    where = [y + slots_earlier * flow[..., 1], x + slots_earlier * flow[..., 0]]
    return ndimage.map_coordinates(image, where, order=1, mode="nearest")


def compensated(
    images: Float[np.ndarray, "slots h w"], patterns: PatternSet, flow: Float[np.ndarray, "h w 2"], moment: float
) -> Float[np.ndarray, "slots h w"]:
    """The lamps' conditions warped to a moment, in slots; projected patterns stay (their columns would be lost)."""
    out = images.copy()
    for slot in patterns.of("constant", "gradient", "tracking"):
        out[slot] = at_slot(images[slot], flow, moment - slot)
    return out
