"""What drives the maps: a take's markers, or points of a performance's mesh that stand in for them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..clip import Markers, visible
from ..errors import BadInput
from ..mesh import closest_point
from ..rig import Performance
from ..takes.gaps import GapConfig, fill_gaps
from ..transforms import Transform
from .domain import neighbours
from .fit import DetailModel

FEWEST = 0.5
"""Share of the training markers that a take must show at the least."""


@dataclass(frozen=True)
class Drive:
    """Markers for every frame, with the head still."""

    positions: Float[np.ndarray, "frames k 3"]
    """In the training's order, aligned with its neutral, mm; no gaps."""
    T_lab_face: Transform
    """Where the head was, one a frame."""
    guessed: Float[np.ndarray, " j"]
    """Share of the frames in which each of the take's markers was filled in from its neighbours."""


def drive_by_markers(model: DetailModel, markers: Markers, gaps: GapConfig = GapConfig()) -> Drive:
    """A take of the training's markers: matched by label, the head's motion taken out, gaps filled.

    What gap filling leaves open follows the markers round it, which `guessed` tells.

    Raises:
        BadInput: fewer than half of the training's markers, or a frame that shows fewer than three.
    """
    place = {label: i for i, label in enumerate(markers.labels)}
    known = np.array([label in place for label in model.labels])
    if known.mean() < FEWEST:
        missing = [label for label, here in zip(model.labels, known, strict=True) if not here]
        raise BadInput(
            f"the take has {int(known.sum())} of the {len(model.labels)} markers that the maps were trained on "
            f"(not {', '.join(missing[:4])}, ...); record the same markers, or "
            "name a neutral frame, by which the new ones are placed (--place)"
        )
    positions = np.full((len(markers.positions), len(model.labels), 3), np.nan)
    positions[:, known] = markers.positions[:, [place[label] for label in np.array(model.labels)[known]]]
    shown = visible(positions).sum(axis=1)
    if (shown < 3).any():
        raise BadInput(f"frame {int(np.argmax(shown < 3))} shows fewer than 3 of the training's markers; cut it off")
    T_lab_face = model.head.pose(positions)
    still = fill_gaps(T_lab_face.inverse().apply(positions), markers.rate, gaps)
    seen = visible(still)
    return Drive(followed(model, still, seen), T_lab_face, 1 - seen.mean(axis=0))


def drive_by_performance(model: DetailModel, performance: Performance) -> Drive:
    """Any tracked or solved face of the same person: points of its mesh stand in for markers."""
    positions = stand_ins(model, performance)
    T_face_still = model.head.pose(positions)
    still = T_face_still.inverse().apply(positions)
    return Drive(still, performance.T_world_face @ T_face_still, np.zeros(len(model.labels)))


def stand_ins(model: DetailModel, performance: Performance) -> Float[np.ndarray, "frames k 3"]:
    """Each training marker with the motion, from the neutral, of the point of the rig's neutral nearest to it; mm."""
    neutral = performance.rig.neutral
    D = closest_point(neutral, model.reference).attachment().matrix(neutral)
    moved = np.stack([D @ delta for delta in performance.rig.deltas])
    return model.reference + np.einsum("tk,kmd->tmd", performance.weights, moved)


def followed(
    model: DetailModel, positions: Float[np.ndarray, "frames k 3"], seen: Bool[np.ndarray, "frames k"]
) -> Float[np.ndarray, "frames k 3"]:
    """Markers still missing take their neighbours' mean offset in the coarse mesh, from what is known outwards."""
    offset = np.where(seen[..., None], positions - model.reference, 0.0)
    known, around = seen.copy(), neighbours(model.domain.coarse, len(model.labels))
    while not known.all():
        before = known.copy()
        for marker in np.flatnonzero(~known.all(axis=0)):
            ring = around[marker] if len(around[marker]) else _nearest(model.reference, int(marker))
            count = before[:, ring].sum(axis=1)
            open_here = ~before[:, marker] & (count > 0)
            total = (offset[:, ring] * before[:, ring, None]).sum(axis=1)
            offset[open_here, marker] = total[open_here] / count[open_here, None]
            known[open_here, marker] = True
        if (known == before).all():
            raise BadInput("detail: markers are missing that nothing round them can stand in for; fill the gaps first")
    return model.reference + offset


def _nearest(reference: Float[np.ndarray, "k 3"], marker: int, count: int = 3) -> np.ndarray:
    """The markers nearest to one that no triangle holds."""
    distance = np.linalg.norm(reference - reference[marker], axis=1)
    return np.argsort(distance)[1 : count + 1]
