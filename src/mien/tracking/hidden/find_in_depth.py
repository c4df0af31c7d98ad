"""Where the face is, from depth alone: for a start where landmarks are few, or none."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from ..._kernels import track
from ...camera import Camera
from ...depth import RGBDFrame
from ...transforms import Transform, rotation_from_vector
from ..model import TrackingModel
from ..preprocess_frame import FrameObservation, preprocess_frame
from ..rigid import RigidConfig, align, correspond

NEAREST_SHARE, HEAD_MM = 0.02, 300.0
"""The person is what lies within this behind the nearest share of the depth."""
STEP_MM = 45.0
"""Between two places that are tried."""
MOST_PLACES = 60
"""Of more, every so manieth: a head with shoulders has some 30, a wall in the background no end."""
TURNS = (-0.3, 0.0, 0.3)
"""Turns to either side that are tried, radians."""
ROUNDS, LAST_ROUNDS, BEST = 4, 15, 6
"""ICP steps of every try, and of the best ones after."""
NEAR_MM = 2.0
"""A vertex so far off the depth counts half."""
ENOUGH = 0.3
"""Share of what faces the camera that must lie on the depth, so counted."""
LEAST = 0.02
"""Share that must correspond for a try to go on."""
FACING = np.diag([1.0, -1.0, -1.0])
"""R_camera_face of a head that looks into the camera."""


def find_in_depth(model: TrackingModel, frame: RGBDFrame, camera: Camera, config: RigidConfig) -> Transform | None:
    """T_camera_face of the neutral on the depth, from tries all over the nearest surface; None where none fits."""
    observation = preprocess_frame(frame, camera, None, None)
    if observation.depth is None or not (observation.depth > 0).any():
        return None
    starts = [
        Transform(FACING @ (R := rotation_from_vector(np.array([0.0, turn, 0.0]))), place - FACING @ R @ model.centre)
        for place in _places(observation.depth, camera)
        for turn in TURNS
    ]
    few = replace(config, enough=0.0, least=LEAST, iterations=ROUNDS)
    tried = [_aligned(model, observation, T, few) for T in starts]
    best = sorted(tried, key=lambda found: -found[0])[:BEST]
    more = replace(few, iterations=LAST_ROUNDS)
    ended = [_aligned(model, observation, T, more) for _, T in best]
    score, T_camera_face = max(ended, key=lambda found: found[0], default=(0.0, None))
    return T_camera_face if score > ENOUGH else None


def _places(depth: Float[np.ndarray, "h w"], camera: Camera) -> Float[np.ndarray, "p 3"]:
    """Points of the nearest surface, a step apart, camera space, mm."""
    there = depth[depth > 0]
    nearest = float(np.quantile(there, NEAREST_SHARE))
    step = max(1, round(STEP_MM * camera.fx / nearest))
    rows, columns = np.mgrid[step // 2 : depth.shape[0] : step, step // 2 : depth.shape[1] : step]
    z = depth[rows, columns]
    near = (z > 0) & (z < nearest + HEAD_MM)
    pixels = np.stack([columns[near], rows[near]], 1).astype(np.float64)
    places = camera.rays(pixels) * z[near][:, None]
    return places[:: -(-len(places) // MOST_PLACES)] if len(places) else places


def _aligned(
    model: TrackingModel, observation: FrameObservation, start: Transform, config: RigidConfig
) -> tuple[float, Transform]:
    """(how much of the model lies on the depth, 0..1, where)."""
    T = align(model.neutral, model.faces, model.share, start, observation, config).T_camera_face
    normals = track.vertex_normals(model.neutral, model.faces)
    match = correspond(model.neutral, normals, T, observation, config)
    off = np.einsum("fd,fd->f", match.found - match.points, match.plane)
    near = (match.weight > 0) / (1 + (off / NEAR_MM) ** 2)
    turned, rays = normals @ T.rotation.T, -match.points
    facing = np.einsum("fd,fd->f", turned, rays) > config.least_cosine * np.linalg.norm(rays, axis=1)
    return float((model.share * near).sum() / max(model.share[facing].sum(), 1e-9)), T
