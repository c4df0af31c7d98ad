"""Lower teeth and tongue of the bundled topology behind a person's skin, whatever is mixed with an open jaw.

A captured smile lies close to the teeth, and so does a chin whose jaw is open; together they would lie behind them.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from ...faces.bundled import BundledFace
from ...mesh import Mesh
from ...pictures.raycast import RayCaster
from ...rig import Rig

SIZES = (1.0, 0.95, 0.9, 0.85)
"""Of the lower arch beside the bundled one's: the largest that stays behind the skin is taken, else the last."""
LEAST_MM = 0.5
"""Skin before a tooth is at least so thick."""
OUTSIDE_MM = 30.0
"""From so far outside skin is looked for before a tooth ..."""
LARGEST_MM = 8.0
"""... and what lies deeper behind a tooth is no skin that it came through, but the mouth."""
MOVES_MM = 1.0
"""Shapes that move no skin before the teeth by so much are not tried."""


def lower_teeth_behind_skin(rig: Rig, face: BundledFace) -> Rig:
    """The rig with as small a lower arch as its shapes ask for, each tried with the jaw open (bundled topology)."""
    poses, skin = _poses(rig, face), rig.neutral.faces[face.skin_faces]
    for size in SIZES:
        vertices = with_arch(rig.neutral.vertices, face, size)
        if all(skin_before_teeth(Mesh(vertices + pose, skin), face) >= LEAST_MM for pose in poses):
            break
    return replace(rig, neutral=rig.neutral.with_vertices(vertices))


def with_arch(vertices: Float[np.ndarray, "n 3"], face: BundledFace, size: float) -> Float[np.ndarray, "n 3"]:
    """Lower teeth and tongue smaller along x and z about the middle of the arch's ends."""
    middle = _middle(vertices[face.parts["lower_teeth"]])
    inside = np.concatenate([face.parts["lower_teeth"], face.parts["tongue"]])
    out = vertices.copy()
    out[inside] += (size - 1) * np.array([1.0, 0.0, 1.0]) * (vertices[inside] - middle)
    return out


def _poses(rig: Rig, face: BundledFace) -> list[Float[np.ndarray, "n 3"]]:
    """Displacements of the open jaw, and of it with every shape of the lower face, both sides together."""
    jaw = rig.deltas[rig.index("jawOpen")] if "jawOpen" in rig.names else np.zeros_like(rig.neutral.vertices)
    below = face.regions["lower"] > 0
    poses = [jaw]
    for name, delta in zip(rig.names, rig.deltas, strict=True):
        other = name.removesuffix("Left") + "Right"
        both = delta + rig.deltas[rig.index(other)] if name.endswith("Left") and other in rig.names else delta
        if name != "jawOpen" and np.linalg.norm(both[below], axis=1).max() > MOVES_MM:
            poses.append(jaw + both)
    return poses


def skin_before_teeth(skin: Mesh, face: BundledFace) -> float:
    """The least thickness of skin before a lower tooth, mm; negative where one has come through, inf where none is
    covered. `skin` has all vertices of the bundled topology and the skin's triangles."""
    teeth = skin.vertices[face.parts["lower_teeth"]]
    outward = (teeth - _middle(teeth)) * [1.0, 0.0, 1.0]
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
    from_outside = RayCaster(skin).cast(teeth + OUTSIDE_MM * outward, -outward, OUTSIDE_MM + LARGEST_MM)
    return float(np.nanmin(OUTSIDE_MM - from_outside.distances, initial=np.inf))


def _middle(teeth: Float[np.ndarray, "t 3"]) -> Float[np.ndarray, "3"]:
    """Between the ends of the arch, at height 0."""
    return np.array([teeth[:, 0].mean(), 0.0, teeth[:, 2].min()])
