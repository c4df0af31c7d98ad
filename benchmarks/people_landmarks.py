"""Our landmarks against the 68 of Multi-PIE that people set: on lids, lips and brows.

Both kinds lie on the same curves, but not at the same places along them: Multi-PIE spaces its points evenly, and marks
the brows' tips, where MediaPipe's stop 5 to 10 mm short. So what counts is how far a point that people set is from
*our curve*; corners of eyes and mouth are points in both and count as such. Distances from point to point, like with
like by number, are there too: most of them is spacing.
"""

import json
from pathlib import Path

import numpy as np

from mien.landmarks.detector import bundled_landmarks

JAMES = (*range(17), *range(29, 34), *range(43, 48), *range(34, 43), *range(17, 29), *range(48, 68))
"""Multi-PIE's order in menpo3d's james.ljson: chin, brows, nose, eyes, mouth; the subject's right side first."""
ICT_FACEKIT = (
    *(1278, 1272, 12, 1834, 243, 781, 2199, 1447, 966, 3661, 4390, 3022, 2484, 4036, 2253, 3490, 3496),
    *(268, 493, 1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509),
    *(978, 4527, 4942, 4857, 1140, 2075, 1147, 4269, 3360),
    *(1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756, 3721, 3725, 3732),
    *(5708, 5695, 2081, 0, 4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841),
    *(5702, 5711, 5533, 6216, 6207, 6470, 5517, 5966),
)
"""Vertices of ICT-FaceKit that its authors name as the 68 (its README)."""
CURVES = {
    "lids": (
        ((37, 38), (33, 246, 161, 160, 159, 158, 157, 173, 133)),
        ((40, 41), (33, 7, 163, 144, 145, 153, 154, 155, 133)),
        ((43, 44), (362, 398, 384, 385, 386, 387, 388, 466, 263)),
        ((46, 47), (362, 382, 381, 380, 374, 373, 390, 249, 263)),
    ),
    "lips": (
        ((49, 50, 51, 52, 53), (61, 185, 40, 39, 37, 0, 267, 269, 270, 409, 291)),
        ((55, 56, 57, 58, 59), (61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291)),
        ((61, 62, 63), (78, 191, 80, 81, 82, 13, 312, 311, 310, 415, 308)),
        ((65, 66, 67), (78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308)),
    ),
    "brows": (((18, 19, 20), (70, 63, 105, 66, 107)), ((23, 24, 25), (336, 296, 334, 293, 300))),
}
"""Which of the 68 (counted from 0) lie on which curve of ours."""
EYES = (33, 160, 158, 133, 153, 144, 362, 385, 387, 263, 373, 380)
LIPS = (61, 40, 37, 0, 267, 270, 291, 321, 314, 17, 84, 91, 78, 81, 13, 311, 308, 402, 14, 178)
BROWS = (70, 63, 105, 66, 107, 336, 296, 334, 293, 300)
POINTS = {
    "corners of eyes": ((36, 39, 42, 45), (33, 133, 362, 263)),
    "corners of the mouth": ((48, 54, 60, 64), (61, 291, 78, 308)),
    "lids by number": (range(36, 48), EYES),
    "lips by number": (range(48, 68), LIPS),
    "brows by number": (range(17, 27), BROWS),
}


def read_people(path: Path) -> np.ndarray:
    """The 68 of a scan in its own frame: james.ljson, or a true scan of ICT-FaceKit (.npz)."""
    if path.suffix == ".npz":
        with np.load(path) as truth:
            return truth["vertices"].astype(float)[list(ICT_FACEKIT)]
    stored = json.loads(path.read_text())["groups"]["LJSON"]["landmarks"]["points"]
    return np.array(stored, float)[list(JAMES)]


def against_people(found, theirs: np.ndarray) -> dict[str, float]:
    """Mean distances of landmarks that people set (scan's frame) from a `Registration`'s, mm."""
    placed = found.T_face_scan.apply(theirs)
    ours = bundled_landmarks().attachment.points(found.mesh)
    means = {}
    for name, curves in CURVES.items():
        off = [from_curve(placed[i], ours[list(curve)]) for ids, curve in curves for i in ids]
        means[name] = float(np.mean(off))
    for name, (ids, same) in POINTS.items():
        means[name] = float(np.linalg.norm(placed[list(ids)] - ours[list(same)], axis=1).mean())
    return means


def from_curve(point: np.ndarray, curve: np.ndarray) -> float:
    """Distance of a point from a polyline."""
    start, way = curve[:-1], np.diff(curve, axis=0)
    share = np.clip(((point - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0, 1)
    return float(np.linalg.norm(point - start - share[:, None] * way, axis=1).min())
