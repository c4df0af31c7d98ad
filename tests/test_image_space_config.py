"""Settings of the fine-scale step that cannot be are named."""

import pytest

from mien.errors import BadInput
from mien.image_space.config import COLOUR, CURVATURE, FineConfig


@pytest.mark.parametrize(
    "wrong", [{"neighbours": 0}, {"pixel_mm": -1.0}, {"alpha": -0.1}, {"threshold": float("nan")}, {"sweeps": -1}]
)
def test_what_is_out_of_range_is_named(wrong):
    (name,) = wrong
    with pytest.raises(BadInput, match=f"fine registration: {name} out of range"):
        FineConfig(**wrong)


def test_steps_can_be_switched_off():
    config = FineConfig(sweeps=0, colour=None, alpha=0.0)
    assert (config.sweeps, config.colour, config.curvature) == (0, None, CURVATURE)
    assert FineConfig().colour == COLOUR
