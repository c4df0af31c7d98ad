"""People whom the identity space does not know."""

import numpy as np
import pytest

from mien.faces import load_face
from mien.stage.people.holdout_identities import load_holdout_identities


@pytest.fixture(scope="module")
def face():
    return load_face()


def test_holdout_identities_lie_outside_the_identity_space(face):
    names, fields = load_holdout_identities()
    assert len(names) == len(set(names)) == len(fields) > 60
    assert fields.shape[1:] == face.rig.neutral.vertices.shape
    region = face.regions["face"] > 0.5
    basis, _ = np.linalg.qr(face.identity.modes[:, region].reshape(len(face.identity.modes), -1).T)
    flat = fields[:, region].reshape(len(fields), -1)
    size = np.linalg.norm(flat, axis=1)
    moving = size > 1
    outside = np.linalg.norm(flat - (flat @ basis) @ basis.T, axis=1)[moving] / size[moving]
    assert np.median(outside) > 0.3
