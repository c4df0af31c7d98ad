"""The bundled expressions' motion as a start."""

import numpy as np

from blendshape_faces import LAYOUT, face_landmarks, face_mesh
from mien.blendshapes.correspond.model_motion import mix_of, motion_image
from mien.faces import load_face


def test_a_known_mix_is_found_again():
    rig = load_face().rig
    weights = mix_of(rig.deltas, face_mesh(), face_landmarks(jawOpen=0.6), face_landmarks())
    assert abs(weights[rig.index("jawOpen")] - 0.6) < 0.12
    assert np.sort(weights)[-2] < 0.2


def test_motion_is_drawn_where_the_skin_is_and_lips_part_along_their_line():
    moved = face_mesh(jawOpen=0.7).vertices - face_mesh().vertices
    flow = motion_image(face_mesh(), moved, LAYOUT)
    chin, nose = (np.round(face_landmarks().pixels(LAYOUT)[i]).astype(int) for i in (200, 4))
    assert flow[chin[1], chin[0], 1] > 10
    assert abs(flow[nose[1], nose[0], 1]) < 1
    assert np.isfinite(flow).all()
    line = np.round(face_landmarks().pixels(LAYOUT)[13]).astype(int)
    across = flow[line[1] - 4 : line[1] + 5, line[0], 1]
    assert np.diff(across).max() > 4
