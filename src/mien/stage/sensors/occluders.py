"""What else a camera sees: shoulders, a hand that comes in the way."""

import numpy as np
import trimesh
from jaxtyping import Float

from ...mesh import Mesh

SHIRT, SKIN = np.array([0.22, 0.27, 0.36]), np.array([0.72, 0.52, 0.42])


def join(meshes: list[Mesh]) -> Mesh:
    """One mesh of several, vertices one after the other; all must have colours."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + start for m, start in zip(meshes, starts, strict=False)]),
        colors=np.concatenate([_colors(m) for m in meshes]),
    )


def shoulders(collar: Float[np.ndarray, " 3"]) -> Mesh:
    """Shoulders and a chest in a shirt round a collar at `collar`, face space, mm."""
    chest = _ball([215.0, 150.0, 95.0], collar + np.array([0.0, -165.0, -45.0]))
    ring = _ball([72.0, 45.0, 72.0], collar + np.array([0.0, -25.0, -12.0]))
    return _painted(join([_painted(chest, SHIRT), _painted(ring, SHIRT * 0.8)]), SHIRT)


def hand() -> Mesh:
    """A right hand with spread fingers, palm towards +Z, fingers up, its middle at the origin, mm."""
    parts = [_ball([42.0, 46.0, 14.0], np.zeros(3))]
    for x, lean, length in ((-30, -0.16, 72), (-10, -0.04, 84), (11, 0.05, 78), (31, 0.17, 62)):
        parts.append(_finger([x, 40.0, 0.0], [np.sin(lean), np.cos(lean), 0.05], length, 9.5))
    parts.append(_finger([-38.0, -8.0, 4.0], [-0.75, 0.66, 0.1], 58, 11.0))
    return _painted(join([_painted(p, SKIN) for p in parts]), SKIN)


def _finger(root: list[float], direction: list[float], length: float, radius: float) -> Mesh:
    capsule = trimesh.creation.capsule(height=length, radius=radius, count=[10, 14])
    turn = np.asarray(trimesh.geometry.align_vectors([0, 0, 1], direction))[:3, :3]
    return Mesh(capsule.vertices @ turn.T + root, np.asarray(capsule.faces))


def _ball(radii: list[float], centre: np.ndarray) -> Mesh:
    ball = trimesh.creation.icosphere(3)
    return Mesh(ball.vertices * radii + centre, np.asarray(ball.faces))


def _painted(mesh: Mesh, color: np.ndarray) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces, colors=np.tile(color, (len(mesh.vertices), 1)))


def _colors(mesh: Mesh) -> np.ndarray:
    return mesh.colors if mesh.colors is not None else np.full((len(mesh.vertices), 3), 0.7)
