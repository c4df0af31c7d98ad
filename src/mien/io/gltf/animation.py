"""glTF animations: keys of morph weights and node poses, sampled at even times."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...transforms import Transform
from .glb import Glb
from .scene import chain_of, global_matrix, head_joint, node_matrices

_HIGHEST_RATE = 1000.0


def weight_animation(
    glb: Glb, chain: list[int], shapes: int
) -> tuple[Float[np.ndarray, "frames shapes"], Float[np.ndarray, " frames"], float, dict[str, Any]]:
    """Weights at even times, those times in seconds, their rate, and the animation that they are from.

    Raises:
        BadInput: no animation moves the weights of the node at the chain's end.
    """
    for animation in glb.json.get("animations", []):
        keys = _keys(glb, animation, chain[-1:], "weights")
        if keys is not None:
            times, values, step = keys
            stated = [(glb.json["nodes"][n].get("extras") or {}).get("rate") for n in chain]
            even, rate = even_times(times, next((float(r) for r in stated if r), None))
            return sample(times, values.reshape(len(times), shapes), even, step), even, rate, animation
    raise BadInput(f"{glb.path}: no animation moves its morph weights, so it is a rig, not a performance")


def face_motion(
    glb: Glb, chain: list[int], animation: dict[str, Any], times: Float[np.ndarray, " frames"], rest: np.ndarray
) -> Transform:
    """Where the animation takes the mesh (skinned: the head's bone) from its rest pose, a rigid motion a frame, metres.

    Raises:
        BadInput: it changes the mesh's size.
    """
    joint = head_joint(glb, chain[-1]) if chain and "skin" in glb.json["nodes"][chain[-1]] else None
    if joint is not None:
        chain, rest = chain_of(glb, joint), global_matrix(glb, joint)
    whole = np.tile(np.eye(4), (len(times), 1, 1))
    for n in chain:
        node = glb.json["nodes"][n]
        if "skin" in node:
            break
        animated = {}
        for path in ("translation", "rotation", "scale"):
            keys = _keys(glb, animation, [n], path)
            if keys is not None:
                animated[path] = sample(*keys[:2], times, keys[2], unit=path == "rotation")
        whole = whole @ node_matrices(node, animated, len(times))
    motion = whole @ np.linalg.inv(rest)
    size = np.cbrt(np.linalg.det(motion[:, :3, :3]))
    if np.abs(size - 1).max() > 0.01:
        raise BadInput(f"{glb.path}: its animation changes the head's size (to {size.max():.3g}); bake the scale in")
    u, _, vt = np.linalg.svd(motion[:, :3, :3])
    return Transform(u @ vt, motion[:, :3, 3])


def even_times(times: Float[np.ndarray, " keys"], rate: float | None) -> tuple[Float[np.ndarray, " frames"], float]:
    """Times from first to last key at `rate`, by default that of the keys' median spacing (30 if there is one key)."""
    if rate is None:
        rate = 30.0 if len(times) < 2 else 1.0 / max(float(np.median(np.diff(times))), 1 / _HIGHEST_RATE)
        rate = float(round(rate)) if abs(rate - round(rate)) < 1e-3 * rate else rate
    count = round(float(times[-1] - times[0]) * rate) + 1
    even = times[0] + np.arange(count) / rate
    if count == len(times) and np.abs(even - times).max() < 0.01 / rate:
        return times, rate
    return even, rate


def sample(
    times: Float[np.ndarray, " keys"],
    values: Float[np.ndarray, "keys width"],
    at: Float[np.ndarray, " frames"],
    step: bool = False,
    unit: bool = False,
) -> Float[np.ndarray, "frames width"]:
    """Keys -> values at other times: linear, or held with `step`; past the ends the end keys. `unit`: quaternions."""
    if unit and len(values) > 1:
        flips = np.where((values[1:] * values[:-1]).sum(axis=1) < 0, -1.0, 1.0)
        values = values * np.r_[1.0, np.cumprod(flips)][:, None]
    if step:
        return values[np.clip(np.searchsorted(times, at + 1e-6, side="right") - 1, 0, len(times) - 1)]
    out = np.stack([np.interp(at, times, column) for column in values.T], axis=1)
    return out / np.linalg.norm(out, axis=1, keepdims=True) if unit else out


def _keys(
    glb: Glb, animation: dict[str, Any], nodes: list[int], path: str
) -> tuple[Float[np.ndarray, " keys"], np.ndarray, bool] | None:
    """Times, values (keys, ...) and whether they are steps. Of cubic splines the keys are taken, not the tangents."""
    for channel in animation["channels"]:
        target = channel["target"]
        if target.get("node") in nodes and target["path"] == path:
            sampler = animation["samplers"][channel["sampler"]]
            kind = sampler.get("interpolation", "LINEAR")
            times, values = glb.accessor(sampler["input"]), glb.accessor(sampler["output"])
            spline = kind == "CUBICSPLINE"
            values = values.reshape(len(times), 3, -1)[:, 1] if spline else values.reshape(len(times), -1)
            return times, values, kind == "STEP"
    return None
