"""Textures in step with a performance."""

import numpy as np
import pytest

from mien.blendshapes.build.rig_files import write_textured_rig
from mien.blendshapes.play import textures_of
from mien.errors import BadInput
from mien.rig import Performance
from mien.transforms import Transform
from test_blendshapes_build_masks import textured


def test_textures_change_with_the_weights(tmp_path):
    write_textured_rig(tmp_path / "me.glb", textured())
    weights = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    performance = Performance(textured().rig, weights, Transform.identity(3), 30.0, np.ones(3, bool))
    pictures = textures_of(performance, tmp_path / "me.glb")
    assert (pictures(0) == 100).all()
    assert (pictures(1)[2:] > 190).all()
    assert (pictures(2)[:2] < 55).all()
    (tmp_path / "me.rig.json").unlink()
    with pytest.raises(BadInput, match="no textures beside it"):
        textures_of(performance, tmp_path / "me.glb")
