"""A performance for other programs.

The same face goes out as glTF, USD and Alembic, as Live Link Face's table and as virtual markers, and comes in again.
"""

import sys
from pathlib import Path

import numpy as np

import mien
from mien.io.alembic import write_alembic
from mien.io.livelink import write_live_link
from mien.rig.virtual_markers import sample_markers, virtual_markers
from mien.transforms import Transform

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
rig = mien.load_face().rig
time = np.arange(60) / 30.0
weights = np.zeros((60, len(rig.names)))
weights[:, rig.index("jawOpen")] = 0.5 - 0.5 * np.cos(4 * time)
performance = mien.Performance(rig, weights, Transform.identity(60), 30.0, np.ones(60, bool))

for name in ("talk.glb", "talk.usdc"):
    mien.write_performance(folder / name, performance)
write_alembic(folder / "talk.abc", performance)
write_live_link(folder / "talk.csv", performance)

markers = virtual_markers(performance, sample_markers(rig, 40), [f"v{i}" for i in range(40)])
back = mien.read_performance(folder / "talk.usdc")
print(markers)
print(f"{back}: weights within {np.abs(back.weights - weights).max():.1e}")
