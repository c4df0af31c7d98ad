"""Motion carried from the markers over the skin between them."""

import numpy as np
import pytest

from marker_stage import held
from mien.faces import load_face
from mien.markers.between_markers import BetweenConfig, carry_between_markers, carry_share
from mien.takes.motion_covariance import motion_covariance


@pytest.fixture(scope="module")
def carried():
    """Sixty markers on the bundled face, and the covariance of its skin with them."""
    face, places = load_face(), held()
    return face, places, motion_covariance(face.rig, places, face.parts["skin"])


def test_the_share_grows_with_what_carried_motion_saves():
    config = BetweenConfig(gain=2.0, most=0.5)
    assert carry_share(1.0, 1.2, config) == 0
    assert carry_share(1.0, 0.9, config) == pytest.approx(0.2)
    assert carry_share(1.0, 0.3, config) == 0.5
    assert carry_share(np.nan, 0.3, config) == 0


def test_a_bent_shape_keeps_its_motion_at_markers_and_that_of_lids_and_eyeballs(carried):
    face, places, covariance = carried
    D, rng = places.matrix(face.rig.neutral), np.random.default_rng(3)
    foreign = face.rig.deltas + 0.3 * np.abs(face.rig.deltas) * rng.normal(size=face.rig.deltas.shape)
    rig = face.rig.with_shapes(face.rig.neutral, foreign)
    bent = carry_between_markers(rig, places, covariance, face.parts["skin"], 0.5)
    smile, blink = rig.index("mouthSmileLeft"), rig.index("eyeBlinkLeft")
    at = np.linalg.norm(D @ rig.deltas[smile], axis=1).max()
    assert np.linalg.norm(D @ (bent.deltas[smile] - rig.deltas[smile]), axis=1).mean() < 0.1 * at
    assert not np.allclose(bent.deltas[smile], rig.deltas[smile])
    lid = np.argmax(np.linalg.norm(rig.deltas[blink], axis=1))
    np.testing.assert_array_equal(bent.deltas[:, lid], rig.deltas[:, lid])
    np.testing.assert_array_equal(bent.deltas[:, face.parts["left_eye"]], rig.deltas[:, face.parts["left_eye"]])
    untouched = carry_between_markers(rig, places, covariance, face.parts["skin"], 0.0)
    np.testing.assert_array_equal(untouched.deltas, rig.deltas)
