"""Proportions of our own: noses, jaws, brows and chins changed by anatomical warps, and a bumpy field over all."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ...faces.bundled import BundledFace
from ...landmarks.detector import bundled_landmarks


@dataclass(frozen=True)
class Warp:
    """What grows, where, and how far it differs among people."""

    landmark: int
    """MediaPipe's number, on the left side or in the middle; its mirror image goes along, nearly."""
    direction: tuple[float, float, float]
    """Millimetres at one standard deviation; x outwards."""
    reach: float
    """Standard deviation of the bell that fades it, mm."""


WARPS: dict[str, Warp] = {
    "nose length": Warp(4, (0.0, -2.4, 0.4), 12.0),
    "nose tip": Warp(4, (0.0, 0.6, 1.8), 9.0),
    "nose hump": Warp(195, (0.0, 0.0, 1.5), 7.5),
    "nasion": Warp(168, (0.0, 0.5, 1.8), 9.0),
    "nose wings": Warp(278, (1.5, 0.0, 0.3), 7.0),
    "cheekbone": Warp(280, (1.6, 0.5, 1.6), 15.0),
    "hollow cheek": Warp(425, (1.2, 0.0, 2.0), 14.0),
    "jaw angle": Warp(397, (3.2, -0.5, 0.0), 17.0),
    "jaw side": Warp(379, (2.2, -1.2, 0.0), 14.0),
    "chin length": Warp(152, (0.0, -3.0, 0.0), 16.0),
    "chin": Warp(199, (0.0, 0.0, 2.4), 12.0),
    "chin width": Warp(400, (1.8, 0.0, 0.3), 10.0),
    "forehead": Warp(10, (0.0, 1.0, 3.0), 24.0),
    "forehead side": Warp(332, (1.8, 0.0, 1.2), 18.0),
    "brow ridge": Warp(334, (0.0, -0.3, 1.7), 9.0),
    "brow height": Warp(334, (0.0, 1.6, 0.0), 12.0),
    "eye spacing": Warp(386, (1.7, 0.0, 0.0), 17.0),
    "eye depth": Warp(386, (0.0, 0.0, 1.6), 17.0),
    "canthus": Warp(263, (0.3, 1.1, 0.0), 7.0),
    "mouth width": Warp(291, (2.0, 0.0, -0.5), 9.0),
    "mouth corner": Warp(291, (0.0, 1.0, 0.0), 8.0),
    "upper lip": Warp(0, (0.0, 0.7, 1.3), 6.0),
    "lower lip": Warp(17, (0.0, -0.6, 1.4), 6.0),
    "philtrum": Warp(13, (0.0, -1.6, 0.0), 16.0),
    "muzzle": Warp(13, (0.0, 0.0, 1.8), 17.0),
}
STRETCH = (0.018, 0.018, 0.022)
"""Standard deviations of width, height and depth of the whole head, as shares."""


def warp_shape(face: BundledFace, asymmetry: float, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
    """A random person's displacement from the average by all the warps, mm."""
    points, found = face.rig.neutral.vertices, bundled_landmarks()
    marks = found.attachment.points(face.rig.neutral)
    total = points * (np.clip(rng.normal(size=3), -2, 2) * STRETCH)
    for warp in WARPS.values():
        amount = float(np.clip(rng.normal(), -2, 2))
        other = int(found.mirror[warp.landmark])
        for mark in {warp.landmark, other}:
            side = 0.0 if mark == warp.landmark == other else 1.0 if mark == warp.landmark else -1.0
            own = amount + (asymmetry * float(rng.normal()) if side else 0.0)
            distance = np.linalg.norm(points - marks[mark], axis=1)
            bell = np.exp(-0.5 * (distance / warp.reach) ** 2)
            total = total + own * bell[:, None] * (np.array(warp.direction) * [side, 1.0, 1.0])
    return total
