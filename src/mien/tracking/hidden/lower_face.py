"""A face whose upper part a headset hides (Casas et al. 2016, fig. 10): what of it is fitted, and what is not."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from ...landmarks.on_rig import LandmarkMap
from ...rig import Performance, Rig
from ..model import TrackingModel, tracking_model
from ..tracker_context import TrackConfig

UPPER = ("brow", "eye", "cheekSquint")
"""How the shapes are called that a headset hides, ARKit's and the 23 merged ones."""
NOSE_TIP = 4
"""MediaPipe's landmark at whose height what is seen begins."""
LEAST_COVERED = 0.1
"""Share of the model that must lie on the depth: half of it is the mouth's inside, or in the headset's shadow."""


def upper_shapes(names: tuple[str, ...]) -> Bool[np.ndarray, " shapes"]:
    """Which shapes move brows, lids, gaze and the cheeks under the eyes."""
    return np.array([name.startswith(UPPER) for name in names], dtype=bool)


def lower_face_model(rig: Rig, landmarks: LandmarkMap) -> TrackingModel:
    """The model of the lower face: its skin, landmarks and shapes alone."""
    points = landmarks.attachment.points(rig.neutral)
    below = float(points[NOSE_TIP, 1])
    seen = ~upper_shapes(rig.names)
    names = tuple(name for name, there in zip(rig.names, seen, strict=True) if there)
    lower = replace(rig, deltas=rig.deltas[seen], names=names)
    known = landmarks.known & (points[:, 1] < below)
    return tracking_model(lower, replace(landmarks, known=known), below=below)


def lower_face_config(config: TrackConfig) -> TrackConfig:
    """The tracker for a face of which little is seen, and which may have to be found without landmarks."""
    return replace(config, find_in_depth=True, rigid=replace(config.rigid, least=LEAST_COVERED))


def with_upper_shapes(performance: Performance, rig: Rig) -> Performance:
    """A performance of the lower face on the whole rig: its upper shapes at rest, correctives behind."""
    played = performance.rig
    more = [i for i, name in enumerate(played.names) if name not in rig.names]
    names = rig.names + tuple(played.names[i] for i in more)
    weights = np.zeros((len(performance), len(names)))
    weights[:, [names.index(name) for name in played.names]] = performance.weights
    whole = replace(rig, deltas=np.concatenate([rig.deltas, played.deltas[more]]), names=names)
    return replace(performance, rig=whole, weights=weights)
