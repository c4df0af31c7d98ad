"""Markers to an animated face.

A staged performer wears 60 markers for ten seconds; the bundled face is fitted to them, follows them, and is written as
glTF, which opens in Blender, Maya and Unreal. Read your own take with `mien.read_markers("take.c3d")`.
"""

import sys
from pathlib import Path

import mien
from mien.stage import make_performer, marker_layout, perform, scripted

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
performer = make_performer(seed=1)
script = scripted(rate=30.0, seconds=10.0)
take = perform(performer, script.weights, 30.0, marker_layout(performer, 60), seed=1).markers
print(take)

solved = mien.solve_markers(take, mien.load_face())
print(solved)

mien.write_performance(folder / "solved.glb", solved.performance)
mien.show(solved).save(folder / "solved.png")
