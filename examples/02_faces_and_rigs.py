"""The bundled face: its 52 shapes, its people, and how rigs are written and read.

A rig is a neutral mesh and named displacements; weights in 0..1 mix them. A person is a point in the face's identity
space.
"""

import sys
from pathlib import Path

import numpy as np

import mien

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
face = mien.load_face()
print(face)

rng = np.random.default_rng(7)
person = face.person(rng.normal(size=len(face.identity.modes)))
weights = np.zeros(len(person.names))
weights[person.index("jawOpen")] = 0.6
weights[person.index("mouthSmileLeft")] = 1.0
mien.show(person.mesh(weights)).save(folder / "person.png")

mien.write_rig(folder / "person.glb", person)
print(mien.read_rig(folder / "person.glb"))
