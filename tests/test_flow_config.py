"""Settings of the flow."""

import pytest

from mien.errors import BadInput
from mien.flow import FlowConfig


def test_bad_settings_are_named():
    for name, value in (("smoothness", 0.0), ("factor", 1.0), ("overrelaxation", 2.0), ("warps", 0)):
        with pytest.raises(BadInput, match=name):
            FlowConfig(**{name: value})
