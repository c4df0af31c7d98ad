"""One capture on the neutral's mesh: its settings."""

from mien.blendshapes.expression import RigConfig


def test_by_default_every_step_is_on():
    config = RigConfig()
    assert config.model
    assert config.stabilise
    assert config.masks
    assert config.warp.flow is not None
    assert config.complete.rounds > 0
