from dataclasses import replace

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.edits_file import (
    captured_beside,
    edits_beside,
    read_captured,
    read_edited,
    read_layer,
    write_edited,
    write_layer,
)
from mien.io.gltf import read_performance, write_performance
from studio_things import nodding

LAYER = {"keys": {"jawOpen": [{"time": 0.2, "add": -0.3}]}, "bad": []}


@pytest.fixture
def performance():
    return nodding(13)


def jaw(performance):
    return performance.weights[6, performance.rig.index("jawOpen")]


def test_a_rerun_does_not_lose_corrections(performance, tmp_path):
    path, told = tmp_path / "perf.glb", []
    write_edited(path, performance)
    write_layer(edits_beside(path), LAYER)
    assert jaw(read_edited(path, told.append)) == pytest.approx(jaw(performance) - 0.3, abs=1e-6)
    again = replace(performance, weights=performance.weights * 0.9)
    write_edited(path, again, told.append)
    assert jaw(read_performance(path)) == pytest.approx(0.9 * jaw(performance) - 0.3, abs=1e-6)
    assert told == [f"{edits_beside(path)}: 1 corrections applied"] * 2


def test_nothing_is_applied_twice(performance, tmp_path):
    path = tmp_path / "perf.glb"
    write_layer(edits_beside(path), LAYER)
    write_edited(path, performance)
    assert captured_beside(path).is_file()
    assert jaw(read_captured(path)) == pytest.approx(jaw(performance), abs=1e-6)
    assert jaw(read_edited(path)) == pytest.approx(jaw(performance) - 0.3, abs=1e-6)


def test_a_file_that_something_else_wrote_is_a_capture(performance, tmp_path):
    path = tmp_path / "perf.glb"
    write_layer(edits_beside(path), LAYER)
    write_edited(path, performance)
    write_performance(path, replace(performance, weights=performance.weights * 0.5))
    assert jaw(read_captured(path)) == pytest.approx(0.5 * jaw(performance), abs=1e-6)


def test_what_is_no_layer_is_told(tmp_path):
    path = tmp_path / "perf.edits.json"
    assert read_layer(path) == {}
    for text in ("{", '{"keys": {"jawOpen": [{"when": 1}]}}', "[]"):
        path.write_text(text)
        with pytest.raises(BadInput, match=r"perf\.edits\.json: is no"):
            read_layer(path)


def test_shapes_that_the_rig_lacks_are_told(performance, tmp_path):
    path, told = tmp_path / "perf.glb", []
    write_layer(edits_beside(path), {"keys": {"wagEars": [{"time": 0.0, "add": 1.0}]}})
    write_edited(path, performance, told.append)
    np.testing.assert_allclose(read_performance(path).weights, performance.weights, atol=1e-6)
    assert any("wagEars" in line for line in told)
