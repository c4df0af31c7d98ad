"""Settings of the optical flow."""

from dataclasses import dataclass

from mien.errors import BadInput


@dataclass(frozen=True)
class FlowConfig:
    """Settings of `optical_flow`. All lengths in pixels; none depends on the images' units."""

    smoothness: float = 1.0
    """alpha: weight of the smoothness term. More gives smoother flow."""
    brightness: float = 0.1
    """beta: weight of brightness constancy; 0 for none. Low because light changes."""
    gradient: float = 1.0
    """gamma: weight of gradient constancy; 0 for none."""
    contrast: float = 0.5
    """Lower bound of n_I and m_I, relative to their root mean square over the image. Large: strong features rule."""
    data_epsilon: float = 0.1
    """Pixels: residuals well below it are penalised quadratically, well above it linearly."""
    smooth_epsilon: float = 0.05
    """The same for |grad w|: differences of flow between neighbours far above it count as edges of the motion."""
    source_share: float = 0.5
    """How far the linearisation takes the source's derivatives: 0 is the paper's, 0.5 the mean."""
    turn_gradients: bool = True
    """Compare the gradient of the warped target, which turns and stretches with the flow of the last warp. False is the
    paper's gradient constancy, which a rotation or a stretch violates."""
    constraint: float = 100.0
    """Weight of constraints, against about 10 for a strong feature in a channel."""
    reach: float = 8.0
    """Pixels round a constraint where the flow starts, at every level, from what it says."""
    presmooth: float = 0.6
    """Gaussian on both images, pixels; 0 for none."""
    factor: float = 0.5
    """Size of a level relative to the next finer one; 1 or more is not allowed."""
    coarsest: int = 8
    """Shortest side of the coarsest level, pixels. As large as the image: one level only."""
    warps: int = 5
    """Most linearisations a level."""
    inner: int = 2
    """Updates of the penalisers' weights a warp."""
    sweeps: int = 8
    """Relaxation sweeps an update."""
    overrelaxation: float = 1.8
    """SOR's omega, between 0 and 2."""
    tolerance: float = 0.005
    """Pixels: a level is done when a warp moves the flow by less, root mean square."""
    margin: int = 32
    """Pixels kept round the mask: the flow is solved in its bounding box, so give the largest displacement or more."""

    def __post_init__(self):
        positive = ("smoothness", "contrast", "data_epsilon", "smooth_epsilon")
        bad = [name for name in positive if getattr(self, name) <= 0]
        bad += [name for name in ("warps", "inner", "sweeps") if getattr(self, name) < 1]
        bad += ["factor"] if not 0.1 <= self.factor <= 0.95 else []
        bad += ["overrelaxation"] if not 0 < self.overrelaxation < 2 else []
        if bad:
            raise BadInput(f"flow settings: {', '.join(bad)} out of range; see FlowConfig for what each means")
