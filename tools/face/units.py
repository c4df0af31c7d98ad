"""The 52 expression units on the face: sides made alike, eyeballs turned, teeth kept rigid."""

import zipfile

import numpy as np
from scipy.sparse import coo_matrix

from mien.faces.lids import fit_blink

from .contours import Contours, ball
from .layout import MILLIMETRES, Layout
from .makehuman import Base, read_unit

LOOK = {"eyeLookIn": 25.0, "eyeLookOut": 25.0, "eyeLookUp": 15.0, "eyeLookDown": 20.0}
"""Degrees that the eyeballs turn at weight 1."""
CREASED = ("mouthSmile", "mouthDimple", "mouthStretch", "cheekSquint", "cheekPuff", "noseSneer")
"""Units whose data have one sharp fold across the cheek: smoothed there, lids and lips left alone."""


def read_units(wheel: zipfile.ZipFile, base: Base, plan: Layout, neutral: np.ndarray, lines: Contours,
               still: np.ndarray, names) -> np.ndarray:
    """Displacements (52, n, 3) mm from `neutral` (n, 3); `still` (n,) is 1 where no smoothing may go."""
    raw = {name: plan.gather(base, read_unit(wheel, name, len(base.vertices))) * MILLIMETRES for name in names}
    units = {name: _unit(raw, name, plan, neutral) for name in names}
    units = {name: _smoothed(units[name], plan, still) if _bare(name) in CREASED else units[name] for name in names}
    centre, _ = ball(neutral, plan, "left")
    units["eyeBlinkLeft"] = fit_blink(neutral, units["eyeBlinkLeft"], *lines.lids["left"], centre)
    units["eyeBlinkRight"] = units["eyeBlinkLeft"][plan.mirror] * [-1, 1, 1]
    return np.stack([units[name] for name in names])


def _unit(raw: dict[str, np.ndarray], name: str, plan: Layout, neutral: np.ndarray) -> np.ndarray:
    """One unit: the mean of what the data say of it and of the other side's mirror image, then its rigid parts."""
    twin = name.replace("Left", "*").replace("Right", "Left").replace("*", "Right")
    delta = (raw[name] + raw[twin][plan.mirror] * [-1, 1, 1]) / 2
    delta[np.isin(plan.part, (1, 2))] = 0
    for part in (3, 4, 5):
        ids = plan.part == part
        small = np.abs(delta[ids]).max() < 0.5
        if small or part == 4:
            delta[ids] = 0 if small else rigid_motion(neutral[ids], delta[ids])
    look = _bare(name)
    if look in LOOK:
        ids = plan.part == (1 if name.endswith("Left") else 2)
        delta[ids] = turn(neutral[ids], look, name.endswith("Left"))
    return delta


def _bare(name: str) -> str:
    return name.removesuffix("Left").removesuffix("Right")


def _smoothed(delta: np.ndarray, plan: Layout, still: np.ndarray, rounds: int = 2) -> np.ndarray:
    """`delta` half drawn to its neighbours' mean, `rounds` times, as far as `still` lets it."""
    n = len(delta)
    pairs = np.concatenate([plan.quads[:, [i, (i + 1) % 4]] for i in range(4)])
    pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    A = coo_matrix((np.ones(2 * len(pairs)), np.concatenate([pairs, pairs[:, ::-1]]).T), shape=(n, n)).tocsr()
    degree = np.maximum(np.asarray(A.sum(1)), 1)
    for _ in range(rounds):
        delta = delta + 0.5 * (1 - still)[:, None] * (A @ delta / degree - delta)
    return delta


def rigid_motion(points: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """The displacement of `points` by the rigid motion nearest to `delta` (k, 3)."""
    a, b = points.mean(0), (points + delta).mean(0)
    U, _, Vt = np.linalg.svd((points - a).T @ (points + delta - b))
    R = Vt.T @ np.diag([1, 1, np.linalg.det(Vt.T @ U.T)]) @ U.T
    return (points - a) @ R.T + b - points


def turn(points: np.ndarray, look: str, left: bool) -> np.ndarray:
    """The displacement of an eyeball that looks in, out, up or down."""
    angle = np.radians(LOOK[look])
    c, s = np.cos(angle), np.sin(angle)
    if look in ("eyeLookUp", "eyeLookDown"):
        s = s if look == "eyeLookDown" else -s
        R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    else:
        s = s if (look == "eyeLookOut") == left else -s
        R = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    centre = (points.max(0) + points.min(0)) / 2
    return (points - centre) @ R.T + centre - points
