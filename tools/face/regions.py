"""Masks over the face's vertices, and its colours."""

import numpy as np

from .layout import Layout

UV_MASKS = ("lips", "eyelids", "ears", "inside-mouth")


def step(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 up to `low`, 1 from `high`, smooth between; falls where low > high."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def on_face(mask: np.ndarray, plan: Layout) -> np.ndarray:
    """A mask over the base -> over the face's vertices, alike on both sides; 0 on the eyeballs."""
    here = np.concatenate([mask[plan.source], np.zeros(len(plan.mirror) - len(plan.source))])
    return np.maximum(here, here[plan.mirror])


def identity_weight(vertices: np.ndarray, plan: Layout, uv_masks: dict[str, np.ndarray]) -> np.ndarray:
    """How much each vertex counts in the identity space: the face fully, ears, back and neck little."""
    x, y, z = vertices.T
    front = step(z, 10, 50) * step(y, -125, -100)
    inside = np.maximum(on_face(uv_masks["inside-mouth"], plan), on_face(uv_masks["ears"], plan))
    return np.where(plan.part == 0, 0.05 + 0.95 * front * (1 - inside), 0.05)


def make_regions(vertices, faces, plan: Layout, uv_masks: dict[str, np.ndarray]) -> dict:
    """`regions`: name -> (n,) in 0..1; `uv`: the base's own masks on the face."""
    x, y, z = vertices.T
    uv = {name: on_face(mask, plan) for name, mask in uv_masks.items()}
    skin = (plan.part == 0) * (1 - uv["inside-mouth"]) * (1 - uv["ears"])
    angle = np.abs(np.arctan2(x, z))
    face = skin * step(z, 0, 20) * step(angle, 1.3, 1.1) * step(y, -115, -100) * step(y, 80, 60)
    return {"regions": {"face": face, "narrow": face * step(angle, 0.95, 0.8)}, "uv": uv}


def colours(vertices, plan: Layout, masks: dict) -> np.ndarray:
    """Vertex colours, sRGB in 0..1."""
    c = np.tile([0.80, 0.62, 0.53], (len(vertices), 1))
    c += masks["uv"]["lips"][:, None] * ([0.70, 0.42, 0.40] - c)
    return c
