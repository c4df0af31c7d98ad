"""Painted faces as maps with true landmarks, for tests of correspondence and of the rig."""

from functools import cache

import numpy as np

from mien.blendshapes.correspond.landmarks import MapLandmarks
from mien.blendshapes.cylinder_map import CylinderLayout, CylinderMap, map_of_scan
from mien.faces import load_face
from mien.landmarks.detector import bundled_landmarks
from mien.mesh import Mesh, Scan

LAYOUT = CylinderLayout(1.0)


@cache
def paint() -> np.ndarray:
    """Vertex colours that differ everywhere: waves over the neutral face."""
    points = load_face().rig.neutral.vertices
    rng = np.random.default_rng(3)
    waves = sum(np.sin(points @ rng.normal(size=3) * 0.25 + rng.uniform(0, 6)) for _ in range(8))
    return np.clip(0.5 + 0.06 * waves[:, None] + np.array([0.15, 0.0, -0.1]), 0, 1)


@cache
def face_mesh(**weights: float) -> Mesh:
    rig = load_face().rig
    values = np.array([weights.get(name, 0.0) for name in rig.names])
    mesh = rig.mesh(values)
    return Mesh(mesh.vertices, mesh.faces, mesh.uv, mesh.uv_faces, paint())


@cache
def face_map(name: str = "neutral", **weights: float) -> CylinderMap:
    mesh = face_mesh(**weights)
    return map_of_scan(Scan(Mesh(mesh.vertices, mesh.faces, colors=mesh.colors), name=name), LAYOUT)


@cache
def face_landmarks(**weights: float) -> MapLandmarks:
    points = bundled_landmarks().attachment.points(face_mesh(**weights))
    return MapLandmarks(points, np.ones(len(points), bool))
