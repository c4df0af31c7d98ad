"""Settings of fine-scale registration."""

from dataclasses import dataclass, field

from ..errors import BadInput
from ..flow import FlowConfig


@dataclass(frozen=True)
class FeatureConfig:
    """How one kind of detail is made comparable. Values in its own unit."""

    threshold: float
    """Smaller values are noise and count as 0."""
    saturation: float
    """Values well above it count alike, so that lids and lips do not outweigh wrinkles; inf: as they are."""
    faint: float
    """Rms nearby at which detail counts half; fainter detail is taken for none."""
    broad_mm: float
    """Detail broader than this is taken out, for it moves over the skin with the expression; inf: it stays."""
    nearby_mm: float
    """Values are divided by their rms within about this distance, so that a shallow wrinkle matches a deep one."""


CURVATURE = FeatureConfig(threshold=0.0, saturation=0.25, faint=0.005, broad_mm=5.0, nearby_mm=4.0)
"""1/mm. The paper's is a threshold of 0.05 with the rest switched off; that leaves only the deepest furrows."""
COLOUR = FeatureConfig(threshold=0.0, saturation=0.1, faint=0.004, broad_mm=3.0, nearby_mm=4.0)
"""Luminance of sRGB, 0..1."""


@dataclass(frozen=True)
class FineConfig:
    """How scans are aligned with their neighbours."""

    neighbours: int = 3
    """M: scans that each region of a scan is aligned with."""
    sweeps: int = 3
    """How often every scan is updated, one after the other. 0: nothing moves."""
    alpha: float = 1.0
    """Eq. 11: how much differential coordinates are kept, against the flow."""
    curvature_radius_mm: float = 2.5
    """Quadratic patches are fitted to what lies within this distance."""
    curvature: FeatureConfig = CURVATURE
    """How curvature is made comparable, 1/mm."""
    colour: FeatureConfig | None = COLOUR
    """The same for the colour of scans that have some; None: curvature alone, as in the paper."""
    reach_mm: float = 4.0
    """The flow is followed about this far beyond evidence."""
    enough: float = 0.3
    """Share of evidence nearby from which on the flow is followed in full."""
    most_mm: float = 3.0
    """Farthest that a sweep moves a vertex."""
    pixel_mm: float = 0.7
    """Side of a pixel of the layout."""
    flow: FlowConfig = field(
        default_factory=lambda: FlowConfig(margin=12, coarsest=32, smoothness=4.0, constraint=1000.0)
    )
    """Its margin, pixels, is kept round every region."""
    threshold: float = 0.05
    """1/mm: curvatures below it count as 0 in the registration error (the paper's threshold)."""
    unreliable: float = 0.035
    """1/mm: a region whose registration error is larger is marked."""

    def __post_init__(self):
        positive = ("neighbours", "curvature_radius_mm", "pixel_mm")
        bad = [name for name in positive if not getattr(self, name) > 0]
        bad += [name for name in ("sweeps", "alpha", "threshold", "unreliable") if not getattr(self, name) >= 0]
        if bad:
            raise BadInput(f"fine registration: {', '.join(bad)} out of range; see FineConfig for what each means")
