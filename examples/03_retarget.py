"""A performance moves to another rig: weights by name, the head's pose as it is.

Head poses and weights are plain arrays, one row a frame, so that a performance can be made without any capture.
"""

import sys
from pathlib import Path

import numpy as np

import mien

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
face = mien.load_face()
frames, rate = 30, 30.0
weights = np.zeros((frames, len(face.rig.names)))
weights[:, face.rig.index("jawOpen")] = np.linspace(0.0, 0.8, frames)
still = mien.Transform.identity(frames)
performance = mien.Performance(face.rig, weights, still, rate, np.ones(frames, bool))

other = face.person(np.linspace(-1.5, 1.5, len(face.identity.modes)))
moved = mien.retarget(performance, other)
print(moved)
mien.write_performance(folder / "moved.glb", moved.performance)
mien.write_live_link(folder / "moved.csv", moved.performance)
