"""A performer moved by muscles: habits of their own, and little of the bundled shapes."""

import numpy as np
import pytest

from mien.faces.arkit import ARKIT_NAMES
from mien.faces.bundled import load_face
from mien.stage import STRANGER, make_performer


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def performer():
    return make_performer(2, STRANGER)


def test_expressions_lie_outside_the_bundled_ones(performer, face):
    skin = face.regions["face"] > 0.5
    ours, theirs = (u[:, skin].reshape(52, -1) for u in (performer.units, face.rig.deltas))
    cosine = (ours * theirs).sum(axis=1) / np.maximum(np.linalg.norm(ours, axis=1) * np.linalg.norm(theirs, axis=1), 1)
    used = [not name.startswith(("eyeLook", "tongue")) for name in ARKIT_NAMES]
    assert 0.4 < np.median(cosine[used]) < 0.75
    assert (np.linalg.norm(ours.reshape(52, -1, 3), axis=2).max(axis=1)[used] > 1.0).all()


def test_half_a_weight_is_not_half_an_expression(performer):
    half, whole = (performer.motion.activations(w * np.eye(52)) for w in (0.5, 1.0))
    used = whole > 0.3
    assert np.abs(half[used] / whole[used] - 0.5).max() > 0.05
    assert ((half[used] > 0.25 * whole[used]) & (half[used] < 0.75 * whole[used])).all()


def test_units_bring_others_along_and_sides_differ(performer):
    drive = performer.motion.drive
    smile = drive[ARKIT_NAMES.index("mouthSmileLeft")]
    assert (smile > 0).sum() > 3
    left, right = (performer.units[ARKIT_NAMES.index(f"mouthSmile{side}")] for side in ("Left", "Right"))
    sizes = np.linalg.norm(left, axis=1).max(), np.linalg.norm(right, axis=1).max()
    assert abs(sizes[0] / sizes[1] - 1) > 0.01
