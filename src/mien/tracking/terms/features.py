"""2D features as rows of the blendshape fit (Li et al. 2013, eq. 2): where landmarks are seen, and how far apart.

A term is rows J and a right-hand side r, both times the root of its weight, as in `tracking.fit`.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from ..._kernels import track, track_fit
from ...landmarks.on_rig import FEATURES, LIDS, LIPS
from ...transforms import Transform
from ..model import TrackingModel
from ..preprocess_frame import FrameObservation
from ..rigid import LEVER
from .fit_config import BlendshapeFitConfig

Rows = tuple[np.ndarray, np.ndarray]
"""J (rows, k + 6) and r (rows,), weighted."""


def feature_rows(
    model, observation: FrameObservation, x, T_camera_face, centre, config: BlendshapeFitConfig
) -> list[Rows]:
    """The terms of the features."""
    if observation.rays is None or not config.features:
        return []
    ids = _landmarks_used(model, observation)
    if observation.depth is None:
        config = replace(config, features=config.alone)
    seen = feature_term(model, ids, observation.rays[ids], x, T_camera_face, centre, config)
    terms = [without_head(*seen) if config.head_relative_landmarks and observation.depth is not None else seen]
    if config.gaps:
        terms.append(gap_term(model, observation.rays, x, T_camera_face, centre, config))
    return terms


def _landmarks_used(model: TrackingModel, observation: FrameObservation) -> np.ndarray:
    """The 40 features beside depth; without depth all the landmarks that are known."""
    if observation.depth is not None:
        return np.array(FEATURES)
    return np.flatnonzero(model.landmarks.known)


def feature_term(
    model: TrackingModel,
    ids: Int[np.ndarray, " j"],
    rays: Float[np.ndarray, "j 2"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
    config: BlendshapeFitConfig,
) -> Rows:
    """2D features, eq. 2: [1 0 -u_x; 0 1 -u_y] v = 0 in camera space; in millimetres at the face.

    More than 40 landmarks share the weight of 40; rays that are NaN give rows of zeros.
    """
    J, points = landmark_rows(model, ids, weights, T_camera_face, centre)
    known = np.asarray(np.isfinite(rays).all(axis=1))
    rays = np.where(np.isfinite(rays), rays, 0.0)
    right = rays * points[:, 2:] - points[:, :2]
    each = np.sqrt(config.features * len(FEATURES) / max(len(ids), 1))
    root = known * each / (1 + (right**2).sum(1) / config.robust_scale_mm**2)
    rows = (J[:, :2] - rays[:, :, None] * J[:, 2:]) * root[:, None, None]
    return rows.reshape(-1, J.shape[2]), (right * root[:, None]).ravel()


def without_head(rows: Float[np.ndarray, "rows c"], right: Float[np.ndarray, " rows"]) -> Rows:
    """Feature rows from which a shift common to all, and any say in the head's pose, are taken out."""
    pairs, offsets = rows.reshape(-1, 2, rows.shape[1]).copy(), right.reshape(-1, 2).copy()
    known = np.abs(pairs).sum((1, 2)) > 0
    pairs[:, :, -6:] = 0.0
    pairs[known] -= pairs[known].mean(0)
    offsets[known] -= offsets[known].mean(0)
    return pairs.reshape(rows.shape), offsets.ravel()


def gap_term(
    model: TrackingModel,
    rays: Float[np.ndarray, "478 2"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
    config: BlendshapeFitConfig,
) -> Rows:
    """Openings between lids and between lips (mm): their 2D difference, on which common errors of both sides cancel."""
    pairs = np.array([*LIDS, *LIPS])
    J, points = landmark_rows(model, pairs.ravel(), weights, T_camera_face, centre)
    z = points[:, 2].mean()
    seen = (rays[pairs[:, 0]] - rays[pairs[:, 1]]) * z
    known = np.isfinite(seen).all(1)[:, None]
    J, points = J.reshape(len(pairs), 2, 3, -1), points.reshape(len(pairs), 2, 3)
    right = np.where(known, seen - (points[:, 0, :2] - points[:, 1, :2]), 0.0)
    rows = (J[:, 0, :2] - J[:, 1, :2]) * known[:, None]
    root = np.sqrt(config.gaps)
    return root * rows.reshape(-1, rows.shape[2]), root * right.ravel()


def landmark_rows(
    model: TrackingModel,
    ids: Int[np.ndarray, " j"],
    weights: Float[np.ndarray, " k"],
    T_camera_face: Transform,
    centre: Float[np.ndarray, " 3"],
) -> tuple[Float[np.ndarray, "j 3 c"], Float[np.ndarray, "j 3"]]:
    """Landmarks in camera space (mm) and their derivatives by the k coefficients, turn and shift (c = k + 6)."""
    return track_fit.landmark_rows(
        model.landmark_neutral[ids], model.landmark_basis[ids], weights, T_camera_face.rotation,
        T_camera_face.translation, centre, LEVER,
    )  # fmt: skip


def normal_equations(terms: list[Rows], shapes: int) -> tuple[Float[np.ndarray, "c c"], Float[np.ndarray, " c"]]:
    """Sum of J'J and of J'r over the terms, float64 (c = shapes + 6)."""
    A, b = np.zeros((shapes + 6, shapes + 6)), np.zeros(shapes + 6)
    for rows, right in terms:
        gram, product = track.normal_equations(rows.astype(np.float32), right.astype(np.float32))
        A += gram
        b += product
    return A, b
