"""Which frame of a take is the neutral face."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from ..clip import visible
from ..errors import BadInput
from ..fitting.marker_identity import IdentityFit
from ..rig import Rig
from ..solve import box_least_squares
from ..takes.frame_solve import SolveConfig, normal_equations, stillness, without_pose
from ..takes.marker_model import MarkerModel, marker_model
from ..takes.stabilise import calm_frames, mean_cloud


@dataclass(frozen=True)
class FindNeutralConfig:
    """How the neutral is told from what is merely held."""

    frame: int | None = None
    """The frame that is neutral, where it is known; None: find it."""
    candidates: int = 10
    """Calm frames that are tried."""
    tie: float = 0.015
    """Candidates this near to the best are told apart by how long they are held."""


@dataclass(frozen=True)
class Neutral:
    """The frame taken as neutral."""

    frame: int
    added: float
    """0..1: of the motion that shapes of either sign explain, the share that shapes which only add explain too. 1: all
    of the take is added to this face; well below: part of it is taken away, so the face is no neutral one."""
    given: bool = False
    """Whether the user named it."""

    @property
    def rests(self) -> bool:
        """Whether the face is neutral there, as far as can be told."""
        return self.added >= NEUTRAL_SHARE

    def line(self, rate: float) -> str:
        """How neutral the neutral is, in one line."""
        where = f"frame {self.frame} ({self.frame / rate:.2f} s{', as told' if self.given else ''})"
        if self.rests:
            return f"the neutral is {where}; {self.added:.0%} of the motion is added to it"
        return (
            f"the take may never rest: from {where}, taken as neutral, only {self.added:.0%} of the motion is added; "
            "expressions are relative to what is held there (--neutral names another frame)"
        )


NEUTRAL_SHARE = 0.9
"""Neutral faces are added to by 91 to 99 % of the motion, held expressions by 58 to 98 %: staged takes below this come
out at two thirds of a frozen face's error and worse; at 0.92 takes are among them that come out at half of it."""


def find_neutral(
    positions: Float[np.ndarray, "frames markers 3"],
    frames: Int[np.ndarray, " trial"],
    rig: Rig,
    fit: IdentityFit,
    metric: Float[np.ndarray, "3 3"] | None,
    solve: SolveConfig,
    config: FindNeutralConfig = FindNeutralConfig(),
) -> Neutral:
    """Of the frames that the take dwells at, the one to which the rest of the take is added.

    An expression is made by adding shapes to the neutral. Counted from a held smile, other frames are partly a smile
    taken away, which shapes in 0..1 cannot do and shapes in -1..1 can: the share of the motion that needs no negative
    weight tells the neutral from what was merely held longest. It does not depend on how well the shapes fit.

    Args:
        positions: head frame, mm; NaN where not seen.
        frames: frames that are tried.
        rig, fit: the person, and where the markers sit on them.

    Raises:
        BadInput: `config.frame` lies outside the take.
    """
    if config.frame is not None:
        if not 0 <= config.frame < len(positions):
            raise BadInput(f"--neutral: the take has frames 0 to {len(positions) - 1}, not {config.frame}")
        return Neutral(config.frame, added_share(positions, frames, config.frame, rig, fit, metric, solve), given=True)
    calm = calm_frames(positions, most=config.candidates)
    shares = np.array([added_share(positions, frames, f, rig, fit, metric, solve) for f in calm])
    first = int(np.argmax(shares >= shares.max() - config.tie))
    return Neutral(calm[first], float(shares[first]))


def added_share(
    positions: Float[np.ndarray, "frames markers 3"],
    frames: Int[np.ndarray, " trial"],
    frame: int,
    rig: Rig,
    fit: IdentityFit,
    metric: Float[np.ndarray, "3 3"] | None,
    solve: SolveConfig,
) -> float:
    """`Neutral.added` of one frame."""
    model = neutral_model(rig, fit, mean_cloud(positions, frame))
    X = positions[frames]
    used = visible(X)
    off = np.nan_to_num(fit.T_face_head.apply(X) - model.neutral)
    M = np.eye(3) if metric is None else metric
    alike = normal_equations(model.jacobian(), M, off, used)
    still = normal_equations(model.jacobian(), M, off, used, stillness(model, solve.still_power))
    gram, linear, _ = without_pose(*alike, *still)
    gram = gram + solve.ridge * np.eye(linear.shape[1])
    adding = box_least_squares(gram, linear, 0.0, 1.0).values
    signed = box_least_squares(gram, linear, -1.0, 1.0).values
    most = _explained(gram, linear, signed)
    return float(_explained(gram, linear, adding) / most) if most > 0 else 1.0


def neutral_model(rig: Rig, fit: IdentityFit, cloud: Float[np.ndarray, "markers 3"]) -> MarkerModel:
    """The markers on the person, `cloud` (head frame) at rest: what identity misses is no expression."""
    model = marker_model(rig, fit.attachment, np.full(len(cloud), fit.standoff_mm))
    return replace(model, neutral=fit.T_face_head.apply(cloud))


def _explained(gram: np.ndarray, linear: np.ndarray, weights: np.ndarray) -> float:
    """How much the weights lower the squared error, mean over frames, mm^2."""
    quadratic = np.einsum("tk,tkl,tl->t", weights, gram, weights, optimize=True)
    return float((2 * (linear * weights).sum(axis=1) - quadratic).mean())
