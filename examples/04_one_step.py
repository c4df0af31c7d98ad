"""One step of a pipeline by itself: head motion taken out of a marker take.

Every step is a plain function from arrays to arrays, with the paper's equation in its docstring.
"""

import numpy as np

import mien
from mien.takes.stabilise import stabilise

rng = np.random.default_rng(0)
frames, rate = 120, 60.0
face = rng.normal(scale=40.0, size=(30, 3))
angle = np.linspace(0.0, 0.5, frames)
turn = np.zeros((frames, 3, 3))
turn[:, 0, 0] = turn[:, 2, 2] = np.cos(angle)
turn[:, 0, 2], turn[:, 2, 0], turn[:, 1, 1] = np.sin(angle), -np.sin(angle), 1.0
positions = np.einsum("tij,mj->tmi", turn, face)
take = mien.Markers(positions, tuple(f"m{i}" for i in range(30)), rate)

before = np.ptp(take.positions, axis=0).mean()
after = np.ptp(stabilise(take).markers.positions, axis=0).mean()
print(f"markers move {before:.1f} mm with the head, {after:.4f} mm on it")
