"""The blendshape fit's one channel of settings."""

from dataclasses import dataclass, field

from .photometric import PhotometricConfig


@dataclass(frozen=True)
class BlendshapeFitConfig:
    """The blendshape fit. Weights are squared, in the units of `tracking.fit`'s first lines."""

    rounds: int = 2
    """Times that correspondences are found anew; a third moves no figure by half a point."""
    features: float = 0.5
    """Weight of a 2D feature; 0 = depth alone. The paper's is 13.8; MediaPipe's points err by 0.5 to 1 mm in ways that
    do not average out, so that here they are worth little."""
    alone: float = 13.8
    """The same where there is no depth."""
    gaps: float = 0.0
    """Weight of the opening between two lids or lips, which errors common to both do not touch; 0 = none. Off, since
    MediaPipe's openings err by half a millimetre and more."""
    robust_scale_mm: float = 30.0
    """Residuals much above this lose weight, mm. Large = plain least squares."""
    ridge: float = 20.0
    """Weight of each squared coefficient."""
    l1: float = 20.0
    """Weight of each coefficient's absolute value: prefers few shapes."""
    l1_per_mm: float = 40.0
    """The same for each millimetre (root mean square over the front) that a shape moves the face at weight 1."""
    reweight_eps: float = 0.15
    """Coefficient at which both of these weigh half: what is surely there is not held back. Large = plain."""
    in_use: float = 0.1
    """Root mean square, over the frames of a recorded take in which a shape is used most, below which it grows dearer
    in a second pass (`terms.weight_prior.dearer_where_idle`); 0 = no such pass."""
    temporal_weight: float = 20.0
    """Weight of the squared change since the last frame."""
    scores: float = 4.0
    """Weight of the squared distance to the landmarker's own scores, each over its variance (`terms.weight_prior`)."""
    eyes: float = 4.0
    """How many times more the scores of lids and gaze count."""
    symmetry: float = 50.0
    """Weight of the squared difference between the two sides of the face; 0 = they know nothing of each other."""
    opposition: float = 50.0
    """Twice the weight of the product of two shapes that undo each other; 0 = none."""
    head_relative_landmarks: bool = True
    """Beside depth, let features speak of one another's places alone, not of the head's: their errors have much in
    common, and depth knows better where the head is. False = the paper's."""
    refine_pose_mm: float = 1.0
    """After each solve the head's pose is measured anew on the steadiest vertices, residuals above this (mm) losing
    weight; 0 = not."""
    photometric: PhotometricConfig = field(default_factory=PhotometricConfig)
    pose: bool = True
    """Let the head move along with the coefficients (past the paper: sec. 4.1 alone leaves up to 3 mm)."""


def colour_alone() -> BlendshapeFitConfig:
    """The fit where there is no depth.

    Landmarks weigh less than the paper's, and so does the picture, above all in what it says of the head, since nothing
    holds that at its distance; shapes are dearer, since landmarks that err are told by them.
    """
    return BlendshapeFitConfig(
        alone=2.0,
        ridge=40.0,
        l1_per_mm=60.0,
        scores=6.0,
        photometric=PhotometricConfig(weight=1000.0, around=9, noise=1.0, head=0.1),
    )
