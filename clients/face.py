"""A face in motion for the clients, and what each must show of it."""

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.faces import load_face
from mien.mesh import vertex_normals
from mien.rig import Performance
from mien.transforms import Transform, rotation_from_vector

HERE = Path(__file__).resolve().parent
FRAMES = (0, 1, 30, 89)
"""Evaluated: both ends, and between."""
TOLERANCE_MM = 0.01
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "mien-clients"


def performance(rate: float = 60.0) -> Performance:
    """The bundled face, 90 frames, every shape at any weight, the head turning and moving."""
    rig = load_face().rig
    rng = np.random.default_rng(0)
    weights = np.clip(rng.random((90, len(rig.names))) * 1.4 - 0.6, 0, 1)
    turns = rotation_from_vector(np.linspace(0, 0.5, 90)[:, None] * np.array([0.3, 1.0, 0.2]))
    pose = Transform(turns, rng.normal(0, 30, (90, 3)))
    return Performance(rig, weights, pose, rate, np.ones(90, bool))


@dataclass(frozen=True)
class Shown:
    """What a client shows of `FRAMES`."""

    points: np.ndarray
    """Millimetres, +Y up, one row a vertex of the client's."""
    normals: np.ndarray
    """Of any length."""
    names: tuple[str, ...]
    rate: float
    frame_range: tuple[int, int]


def off_mm(shown: Shown, play: Performance) -> float:
    """Farthest that a vertex is from where it should be; those that seams add stand behind the rig's own."""
    meshes = [mesh for t, mesh in enumerate(play.meshes(world=True)) if t in FRAMES]
    n = len(play.rig.neutral.vertices)
    differences = [points[:n] - mesh.vertices for points, mesh in zip(shown.points, meshes, strict=True)]
    return float(np.abs(differences).max())


def turned_deg(shown: Shown, play: Performance) -> np.ndarray:
    """Angles between the client's normals and those of the deformed surface, degrees, of all vertices and frames."""
    n = len(play.rig.neutral.vertices)
    used = np.unique(play.rig.neutral.faces)
    found = []
    for t, normals in zip(FRAMES, shown.normals, strict=True):
        mesh = play.rig.mesh(play.weights[t])
        true = play.T_world_face[t].rotate(vertex_normals(mesh.vertices, mesh.faces))[used]
        theirs = normals[:n][used]
        theirs = theirs / np.linalg.norm(theirs, axis=1, keepdims=True)
        found.append(np.degrees(np.arccos(np.clip((true * theirs).sum(axis=1), -1, 1))))
    return np.concatenate(found)


def run(*words: str | Path, **options) -> str:
    """A program to its end; its output, or its own words as the failure."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=600, **options)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout
