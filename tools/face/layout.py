"""The bundled face's own mesh: head and neck cut from the base, rounder eyeballs, teeth, tongue; and its UV."""

from dataclasses import dataclass

import numpy as np

from .makehuman import Base
from .rings import QuadNet
from .uv import pack

MILLIMETRES = 105.0
"""A decimetre of MakeHuman's in millimetres. 100 by its units; 5 % more brings the average adult head nearer to
anthropometric means (pupils 61 mm apart, nasion to menton 115 mm, face 143 mm wide) without leaving any far off."""
NECK = (809, 805)
"""An edge on the front of the neck, of the edge loop where head and neck are cut from the body."""
SOCKET = (7799, 7800)
"""An edge of the ring behind the left eye's lids where the socket is cut off: of people with large eyes it would
come out through the skin."""
PARTS = ("skin", "left_eye", "right_eye", "upper_teeth", "lower_teeth", "tongue")
GROUPS = {"left_eye": "helper-l-eye", "right_eye": "helper-r-eye", "upper_teeth": "helper-upper-teeth",
              "lower_teeth": "helper-lower-teeth", "tongue": "helper-tongue"}
EYE_RADIUS = 0.1496
"""Of the base's eyeballs, decimetres."""
RINGS = np.radians([4, 8, 9.5, 16, 22, 24, 32, 45, 60, 75, 90, 110, 135, 160])
"""The eyeball's circles of latitude, from the pupil's middle: pupil to 8, iris to 22 degrees."""
MERIDIANS = 24


@dataclass(frozen=True)
class Layout:
    """Which of the base's vertices the face has, and how fields on the base come over to it."""

    source: np.ndarray
    """(k,) base vertex of each of the first vertices: skin, then teeth and tongue."""
    eyes: dict[str, np.ndarray]
    """Part -> base vertices of the two old eyeballs."""
    ball: np.ndarray
    """(e, 3) one new eyeball about its centre, unit radius, pupil on +Z."""
    part: np.ndarray
    """(n,) index into PARTS."""
    quads: np.ndarray
    """(m, 4) faces; triangles repeat their last vertex."""
    uv_quads: np.ndarray
    uv: np.ndarray
    mirror: np.ndarray
    """(n,)."""

    def gather(self, base: Base, field: np.ndarray) -> np.ndarray:
        """A displacement field on the base (19158, 3) -> on the face (n, 3), same unit.

        Eyeballs stay round: they take the field's mean and its growth in width and height, no more.
        """
        out = [field[self.source]]
        for old in self.eyes.values():
            centre, growth = ball_motion(base.vertices[old], field[old])
            out.append(centre + growth * self.ball * EYE_RADIUS)
        return np.concatenate(out)

    def positions(self, base: Base) -> np.ndarray:
        """The base itself on the face's vertices (n, 3), decimetres."""
        out = [base.vertices[self.source]]
        out += [base.vertices[old].mean(0) + self.ball * EYE_RADIUS for old in self.eyes.values()]
        return np.concatenate(out)


def ball_motion(points: np.ndarray, field: np.ndarray) -> tuple[np.ndarray, float]:
    """Mean displacement of an eyeball whose `points` (k, 3) move by `field`, and its relative growth across."""
    spokes = (points - points.mean(0))[:, :2]
    return field.mean(0), float((field[:, :2] * spokes).sum() / (spokes**2).sum())


def make_layout(base: Base) -> Layout:
    """Cut, re-mesh the eyeballs, renumber, mirror, lay out the UV."""
    head = _head_quads(base)
    inner = np.concatenate([base.quads_of(GROUPS[part]) for part in ("upper_teeth", "lower_teeth", "tongue")])
    kept = np.concatenate([head, inner])
    skin = np.unique(base.quads[head])
    other = [np.unique(base.quads[base.quads_of(GROUPS[p])]) for p in ("upper_teeth", "lower_teeth", "tongue")]
    source = np.concatenate([skin, *other])
    new = np.full(len(base.vertices), -1)
    new[source] = np.arange(len(source))
    ball, ball_quads = _ball()
    e, k = len(ball), len(source)
    eyes = {p: np.unique(base.quads[base.quads_of(GROUPS[p])]) for p in ("left_eye", "right_eye")}
    part = np.concatenate([np.full(len(skin), 0), *[np.full(len(o), i + 3) for i, o in enumerate(other)],
                           np.full(e, 1), np.full(e, 2)])
    quads = np.concatenate([new[base.quads[kept]], ball_quads + k, ball_quads + k + e])
    flip = _ball_mirror(ball)
    mirror = np.concatenate([new[base.mirror[source]], k + e + flip, k + flip])
    uv, uv_quads = _layout_uv(base, kept, ball, ball_quads, part[quads[:, 0]])
    return Layout(source, eyes, ball, part, quads, uv_quads, uv, mirror)


def triangulate(vertices: np.ndarray, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """Quads -> triangles along the shorter diagonal, alike on both sides; (faces, uv_faces)."""
    q, t = layout.quads, layout.uv_quads
    key = np.minimum(np.arange(len(layout.mirror)), layout.mirror)
    first = np.linalg.norm(vertices[q[:, 0]] - vertices[q[:, 2]], axis=1)
    second = np.linalg.norm(vertices[q[:, 1]] - vertices[q[:, 3]], axis=1)
    tie = np.abs(first - second) < 1e-7
    low = np.minimum(key[q[:, 0]], key[q[:, 2]]) < np.minimum(key[q[:, 1]], key[q[:, 3]])
    three = q[:, 2] == q[:, 3]
    along02 = np.where(tie, low, first < second) | three
    corners = np.where(along02[:, None, None], [[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]])
    faces = np.take_along_axis(q[:, None, :].repeat(2, 1), corners, 2).reshape(-1, 3)
    uv_faces = np.take_along_axis(t[:, None, :].repeat(2, 1), corners, 2).reshape(-1, 3)
    real = faces[:, 1] != faces[:, 2]
    return faces[real], uv_faces[real]


def _head_quads(base: Base) -> np.ndarray:
    """The body's quads above the neck's edge loop, without the sockets behind the eyeballs."""
    body = base.quads_of("body")
    net = QuadNet(base.quads[body])
    left = net.ring(*SOCKET)
    loops = [net.ring(*NECK), left, base.mirror[left]]
    cut = {frozenset(pair) for loop in loops for pair in zip(loop, np.roll(loop, -1), strict=True)}
    start = int(base.vertices[base.quads[body]][:, :, 1].mean(1).argmax())
    reached, queue = {start}, [start]
    while queue:
        here = queue.pop()
        for edge in net.edges(here):
            for other in net.beside[edge] if edge not in cut else ():
                if other not in reached:
                    reached.add(other)
                    queue.append(other)
    return body[sorted(reached)]


def _ball() -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere of rings about +Z with two poles: vertices (e, 3) and quads (triangles repeat their last)."""
    turn = np.arange(MERIDIANS) * 2 * np.pi / MERIDIANS
    a, b = RINGS[:, None], turn[None]
    rings = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a) + 0 * b], -1).reshape(-1, 3)
    ball = np.concatenate([[[0, 0, 1.0]], rings, [[0, 0, -1.0]]])
    i = np.arange(MERIDIANS)
    j = (i + 1) % MERIDIANS
    quads = [np.stack([0 * i, 1 + i, 1 + j, 1 + j], 1)]
    for r in range(len(RINGS) - 1):
        o = 1 + r * MERIDIANS
        quads.append(np.stack([o + i, o + MERIDIANS + i, o + MERIDIANS + j, o + j], 1))
    o, last = 1 + (len(RINGS) - 1) * MERIDIANS, len(ball) - 1
    quads.append(np.stack([o + i, 0 * i + last, o + j, o + j], 1))
    return ball, np.concatenate(quads)


def _ball_mirror(ball: np.ndarray) -> np.ndarray:
    """Which vertex of the ball lies at -x of each."""
    i = np.arange(MERIDIANS)
    around = (MERIDIANS // 2 - i) % MERIDIANS
    rings = 1 + np.arange(len(RINGS))[:, None] * MERIDIANS + around
    flip = np.concatenate([[0], rings.ravel(), [len(ball) - 1]])
    np.testing.assert_allclose(ball[flip] * [-1, 1, 1], ball, atol=1e-12)
    return flip


def _layout_uv(base: Base, kept: np.ndarray, ball: np.ndarray, ball_quads: np.ndarray, part: np.ndarray):
    """UV (u, 2) in 0..1 and corners (m, 4): the base's charts of the `kept` quads, and a disc for each eyeball.

    The back pole is as many points on the rim as it has triangles.
    """
    old, corners = np.unique(base.uv_quads[kept], return_inverse=True)
    angle = np.arccos(np.clip(ball[:-1, 2], -1, 1))[:, None] / np.pi
    across = ball[:-1, :2] / np.maximum(np.linalg.norm(ball[:-1, :2], axis=1, keepdims=True), 1e-9)
    turn = (np.arange(MERIDIANS) + 0.5) * 2 * np.pi / MERIDIANS
    rim = np.stack([np.cos(turn), np.sin(turn)], 1)
    disc = 0.012 * np.concatenate([angle * across, rim])
    ball_corners = ball_quads.copy()
    ball_corners[-MERIDIANS:, 1] = len(ball) - 1 + np.arange(MERIDIANS)
    k, e = len(old), len(disc)
    corners = np.concatenate([corners.reshape(-1, 4), ball_corners + k, ball_corners + k + e])
    return pack(np.concatenate([base.uv[old], disc, disc]), corners, part), corners
