"""Scans in one pose of the head, told from skin that hardly moves whatever the face does.

Markers alone leave the head of each scan half a millimetre off, since most of them sit where faces move: part of a
smile is then taken for a turn of the head. A scan shows the skin between and above them: forehead, temples, the bridge
of the nose (after Beeler and Bradley 2014, Rigid stabilization of facial expressions). Not in the paper.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...fitting.terms import fading
from ...mesh import ClosestPoint, Mesh, mass
from ...register import IcpConfig, Rejection, icp
from ...transforms import Transform
from ..scan_template import ScanTemplate

MOUTH = 0.5
"""From which value of its mask on a vertex counts as mouth."""


@dataclass(frozen=True)
class StillSkinConfig:
    """How scans are brought into one pose of the head."""

    enabled: bool = True
    """Off: the poses are those that the markers gave, as in the paper."""
    still_mm: float = 0.6
    """Skin that the bundled face's shapes move by so much, rms, counts a quarter, and less the farther it moves."""
    icp: IcpConfig = field(
        default_factory=lambda: IcpConfig(robust="geman", rejection=Rejection(max_distance=6.0), max_points=0)
    )
    """Point to plane, down-weighted where the skin did move."""


def stillness(template: ScanTemplate, config: StillSkinConfig) -> Float[np.ndarray, " n"]:
    """How far each of the template's skin vertices tells of the head, with its area; 0 from the upper lip down.

    Chin and neck have still skin in the shapes, but the jaw swings and the neck bends in life.
    """
    mouth = template.regions["mouth"] > MOUTH
    height = template.skin.vertices[:, 1]
    lowest = height[mouth].max() if mouth.any() else -np.inf
    area = mass(template.skin.vertices, template.skin.faces)
    still = fading(template.mobility, config.still_mm)
    return area * still * template.shown * (height > lowest)


def settle_heads(
    template: ScanTemplate,
    shapes: Float[np.ndarray, "scans n 3"],
    neutral: Mesh,
    config: StillSkinConfig = StillSkinConfig(),
) -> list[Transform]:
    """Where each scan belongs so that its still skin lies on that of the neutral scan, the first: T_settled_placed.

    A scan whose still skin is not there (a mask, hair) stays where it is.

    Args:
        shapes: the template's skin on every scan, face space, mm.
        neutral: the neutral scan, face space, mm.
    """
    if not config.enabled:
        return [Transform.identity() for _ in shapes]
    weights, target = stillness(template, config), ClosestPoint(neutral)
    settled = [_settled(template, shape, target, weights, config) for shape in shapes[1:]]
    return [Transform.identity(), *settled]


def _settled(
    template: ScanTemplate, shape: np.ndarray, neutral: ClosestPoint, weights: np.ndarray, config: StillSkinConfig
) -> Transform:
    """One scan's skin onto the neutral scan."""
    mesh = template.skin.with_vertices(shape)
    try:
        return icp(mesh, neutral, config=config.icp, weights=weights).transform
    except BadInput:
        return Transform.identity()


def moved_shapes(
    transforms: Sequence[Transform], shapes: Float[np.ndarray, "scans n 3"]
) -> Float[np.ndarray, "scans n 3"]:
    """Each scan's shape, moved."""
    return np.stack([T.apply(shape) for T, shape in zip(transforms, shapes, strict=True)])
