"""Clips that displacement maps are learnt from, neutral to extreme, and others (Ma et al. 2008, sec. 3 and 6)."""

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...faces.arkit import ARKIT_NAMES
from .poses import VISEMES, both
from .script import minimum_jerk

EXPRESSIONS: dict[str, dict[str, float]] = {
    "happy": both(mouthSmile=0.9, cheekSquint=0.7, eyeSquint=0.3, mouthDimple=0.3, mouthUpperUp=0.25),
    "sad": {"browInnerUp": 0.8, "mouthShrugLower": 0.4, **both(mouthFrown=0.8, eyeSquint=0.2)},
    "anger": {"mouthShrugLower": 0.2, **both(browDown=1.0, eyeSquint=0.5, mouthPress=0.5, noseSneer=0.3)},
    "disgust": {**both(noseSneer=0.95, mouthUpperUp=0.6, browDown=0.4, mouthFrown=0.3, cheekSquint=0.3)},
    "wince": {**both(eyeSquint=0.9, cheekSquint=0.9, mouthStretch=0.7, browDown=0.5, noseSneer=0.3)},
    "surprise": {"browInnerUp": 1.0, "jawOpen": 0.6, **both(browOuterUp=0.95, eyeWide=0.6)},
}
"""The six of the paper's figure 3 as ARKit weights: brows in and out, mouth corners, nose, cheeks, jaw."""

UNSEEN: dict[str, list[dict[str, float]]] = {
    "asymmetric": [{"mouthSmileLeft": 0.8, "cheekSquintLeft": 0.5, "browOuterUpRight": 0.8, "browInnerUp": 0.3}],
    "speech": [VISEMES[name] for name in ("aa", "ee", "oh", "eh", "oo", "aa", "silence")],
    "pout": [{"mouthPucker": 0.3, "mouthShrugLower": 0.7, "mouthRollLower": 0.2, "mouthFrownLeft": 0.5}],
}
"""An asymmetric smile with one brow, a speech sample, and a lip pout, the paper's failure."""

LAG = 0.3
"""A unit starts up to this share of the clip after the others: nobody moves all at once."""


def expression_clip(name: str, frames: int, seed: int = 0) -> Float[np.ndarray, "frames 52"]:
    """Neutral to one of `EXPRESSIONS`.

    Raises:
        BadInput: no such expression, or fewer than two frames.
    """
    if name not in EXPRESSIONS or frames < 2:
        raise BadInput(f"training clip: expected one of {', '.join(EXPRESSIONS)} and two frames or more, got {name}")
    return _towards([EXPRESSIONS[name]], frames, np.random.default_rng([seed, list(EXPRESSIONS).index(name)]))


def unseen_clip(name: str, frames: int, seed: int = 0) -> Float[np.ndarray, "frames 52"]:
    """Neutral through the poses of one of `UNSEEN`."""
    return _towards(UNSEEN[name], frames, np.random.default_rng([seed, 9, list(UNSEEN).index(name)]))


def _towards(poses: list[dict[str, float]], frames: int, rng: np.random.Generator) -> Float[np.ndarray, "frames 52"]:
    """From the neutral to each pose in turn, every unit with a lag of its own."""
    keys = np.array([[pose.get(name, 0.0) for name in ARKIT_NAMES] for pose in [{}, *poses]])
    time = np.linspace(0, len(poses), frames)
    out, lag = np.zeros((frames, len(ARKIT_NAMES))), rng.uniform(0, LAG, len(ARKIT_NAMES))
    for step in range(len(poses)):
        share = np.stack([minimum_jerk((time - step - late) / (1 - LAG)) for late in lag], axis=1)
        out += share * (keys[step + 1] - keys[step])
    return out
