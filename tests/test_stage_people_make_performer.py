"""Random people."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.stage import PerformerConfig, make_performer
from mien.stage.people.make_performer import random_shape


def test_a_negative_seed_is_refused():
    with pytest.raises(BadInput, match="seed"):
        make_performer(-1)


def test_without_any_share_nobody_differs_from_the_average():
    face, nothing = load_face(), PerformerConfig(identity=0.0, holdout=0.0, displacement=0.0)
    np.testing.assert_allclose(random_shape(face, nothing, np.random.default_rng(0)), 0.0, atol=1e-9)


def test_the_displacement_has_the_size_that_is_asked_for_and_teeth_move_as_bodies():
    face, config = load_face(), PerformerConfig(identity=0.0, holdout=0.0, displacement=2.0)
    shape = random_shape(face, config, np.random.default_rng(3))
    rms = np.sqrt((shape[face.parts["skin"]] ** 2).sum(axis=1).mean())
    assert 1.5 < rms < 2.3
    for part in ("lower_teeth", "upper_teeth"):
        np.testing.assert_allclose(np.ptp(shape[face.parts[part]], axis=0), 0.0, atol=1e-9)
