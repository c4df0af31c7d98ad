"""Extras: all that the package declares are told, and a missing one is one line."""

import tomllib
from pathlib import Path

import pytest

from mien.errors import BadInput
from mien.extras import EXTRAS, require

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def test_every_extra_of_the_package_is_told():
    declared = tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"]
    assert set(EXTRAS) == set(declared) - {"all", "docs", "dev"}


def test_a_missing_module_is_told_with_its_extra():
    assert require("json", "usd").dumps([]) == "[]"
    with pytest.raises(BadInput, match=r"USD out and in: nowhere is missing .*; pip install 'mien\[usd\]'"):
        require("nowhere", "usd")
