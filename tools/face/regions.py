"""Smooth masks over the face's vertices."""

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from .layout import Layout

UV_MASKS = ("lips", "eyelids", "ears", "inside-mouth")
OVERLAP = 12.0
"""How far neighbouring regions reach into each other, mm."""


def step(x: np.ndarray, low: float | np.ndarray, high: float | np.ndarray) -> np.ndarray:
    """0 up to `low`, 1 from `high`, smooth between; falls where low > high."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def on_face(mask: np.ndarray, plan: Layout) -> np.ndarray:
    """A mask over the base -> over the face's vertices, alike on both sides; 0 on the eyeballs."""
    here = np.concatenate([mask[plan.source], np.zeros(len(plan.mirror) - len(plan.source))])
    return np.maximum(here, here[plan.mirror])


def identity_weight(vertices: np.ndarray, plan: Layout, uv_masks: dict[str, np.ndarray]) -> np.ndarray:
    """How much each vertex counts in the identity space: the face fully, ears, back and neck little."""
    _, y, z = vertices.T
    front = step(z, 10, 50) * step(y, -125, -100)
    inside = np.maximum(on_face(uv_masks["inside-mouth"], plan), on_face(uv_masks["ears"], plan))
    return np.where(plan.part == 0, 0.05 + 0.95 * front * (1 - inside), 0.05)


def still(plan: Layout, uv_masks: dict[str, np.ndarray]) -> np.ndarray:
    """1 on lips, lids, ears, in the mouth and on all that is not skin; 0 elsewhere."""
    found = np.max([on_face(uv_masks[name], plan) for name in UV_MASKS], axis=0)
    return np.where(plan.part == 0, found, 1.0)


def openness(vertices: np.ndarray, faces: np.ndarray, plan: Layout, directions: int = 64) -> np.ndarray:
    """Share of the directions before each vertex in which nothing is in the way, (n,): 1 on a ball, 0 in a cave."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    normals = np.asarray(mesh.vertex_normals)
    i = np.arange(directions) + 0.5
    up, turn = 1 - 2 * i / directions, np.pi * (1 + 5**0.5) * i
    rays = np.stack([np.sqrt(1 - up**2) * np.cos(turn), np.sqrt(1 - up**2) * np.sin(turn), up], 1)
    caster, free, count = RayMeshIntersector(mesh), np.zeros(len(vertices)), np.zeros(len(vertices))
    for ray in rays:
        before = normals @ ray > 0.1
        start = vertices[before] + 0.05 * normals[before]
        free[before] += ~caster.intersects_any(start, np.tile(ray, (len(start), 1)))
        count += before
    share = free / np.maximum(count, 1)
    return (share + share[plan.mirror]) / 2


def make_regions(vertices: np.ndarray, faces: np.ndarray, plan: Layout, uv_masks: dict) -> dict[str, np.ndarray]:
    """Every mask by name, (n,) in 0..1 each, symmetric or in mirrored pairs."""
    face, narrow = _face(vertices, faces, plan, uv_masks)
    _, y, _ = vertices.T
    eyes = face * _eyes(vertices)
    regions = {
        "face": face,
        "narrow": narrow,
        "upper": face * step(y, -22, -6),
        "eyes": eyes,
        "lower": face * step(y, -14, -30),
    }
    return regions | {name: face * mask for name, mask in _eight(vertices, plan.mirror).items()}


def _face(vertices, faces, plan: Layout, uv_masks) -> tuple[np.ndarray, np.ndarray]:
    """Outer skin from the hairline to the jaw and to before the ears; and the same drawn in by about 12 mm."""
    _, y, z = vertices.T
    inside, ears = (on_face(uv_masks[name], plan) for name in ("inside-mouth", "ears"))
    outer = (plan.part == 0) * (1 - step(inside, 0.2, 0.6)) * (1 - step(ears, 0.05, 0.4))
    outer = outer * step(openness(vertices, faces, plan), 0.08, 0.2)
    jaw = np.interp(z, [0, 15, 35, 60, 90, 120], [-60, -78, -95, -108, -114, -116])
    face = outer * step(y - jaw, -2, 6) * step(z, 4, 20) * step(y, 74, 60)
    narrow = outer * step(y - jaw, 8, 18) * step(z, 28, 42) * step(y, 54, 42)
    return face, narrow


def _eyes(vertices: np.ndarray) -> np.ndarray:
    """Lids and sockets: ellipses about the eyes' middles."""
    x, y, z = vertices.T
    far = np.hypot((np.abs(x) - 31) / 24, (y + 1) / 16)
    return step(far, 1.25, 0.85) * step(z, 40, 55)


def _eight(vertices: np.ndarray, mirror: np.ndarray) -> dict[str, np.ndarray]:
    """Two foreheads, two eyes, two cheeks with half the nose each, mouth, chin (after Huang 2011, figure 6a).

    Where two meet, each is 1 on its own side and falls to 0 within OVERLAP beyond the border, so that everywhere
    at least one is 1.
    """
    x, y, z = vertices.T

    def above(t):
        return step(t, -OVERLAP, 0.0)

    brow = 18 - 6 * step(np.abs(x), 35, 65)
    mouth_edge = 1 - np.hypot(x / 36, np.where(y > -62, (y + 62) / 17, (y + 62) / 21))
    mouth = step(mouth_edge, -0.4, 0) * step(z, 50, 65)
    not_mouth = step(-mouth_edge, -0.4, 0)
    not_mouth = np.maximum(not_mouth, step(z, 65, 50))
    chin_line = -(y + 78) - 0.25 * np.maximum(np.abs(x) - 30, 0)
    left = {
        "forehead": above(y - brow) * above(x),
        "eye": above(brow - y) * above(y + 20) * above(x),
        "cheek": above(-20 - y) * above(-chin_line) * above(x) * not_mouth,
    }
    pairs = {f"{n}_{side}": m if side == "left" else m[mirror] for n, m in left.items() for side in ("left", "right")}
    return pairs | {"mouth": mouth, "chin": above(chin_line) * not_mouth}
