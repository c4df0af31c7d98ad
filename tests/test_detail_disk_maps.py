import json

import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.maps import read_detail, write_detail
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.synthesize import SynthesisConfig, Synthesizer
from mien.errors import BadInput


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), DetailConfig(base=BaseConfig(vertices=0), medium_size=24, fine_size=32))


def test_a_model_comes_back_and_synthesises_the_same(model, tmp_path):
    write_detail(tmp_path / "detail", model)
    back = read_detail(tmp_path / "detail")
    assert back.labels == model.labels
    markers = model.reference * [0.9, 1, 1]
    one, two = (Synthesizer(m, SynthesisConfig(fine_vertices=True)).frame(markers) for m in (model, back))
    np.testing.assert_allclose(two.vertices, one.vertices, atol=1e-4)
    np.testing.assert_allclose(two.fine, one.fine, atol=1e-5)
    np.testing.assert_array_equal(back.fine.unreliable, model.fine.unreliable)


def test_half_maps_are_smaller_and_near(model, tmp_path):
    write_detail(tmp_path / "whole", model)
    write_detail(tmp_path / "half", model, half=True)
    sizes = [(tmp_path / name / "medium.exr").stat().st_size for name in ("whole", "half")]
    assert sizes[1] < 0.7 * sizes[0]
    markers = model.reference * [0.9, 1, 1]
    one, two = (Synthesizer(read_detail(tmp_path / name)).frame(markers) for name in ("whole", "half"))
    np.testing.assert_allclose(two.vertices, one.vertices, atol=0.02)


def test_what_is_no_finished_folder_is_one_line(model, tmp_path):
    with pytest.raises(BadInput, match="no such file"):
        read_detail(tmp_path / "nowhere")
    with pytest.raises(BadInput, match=r"no detail\.json"):
        read_detail(tmp_path)
    folder = tmp_path / "detail"
    write_detail(folder, model)
    record = json.loads((folder / "detail.json").read_text())
    for change, match in (
        ({"format": 99}, "newer version"),
        ({"medium": {"order": 2, "size": 25}}, "not the map"),
        ({"bases": [[1]]}, "does not fit"),
        ({"labels": 3}, "does not fit"),
    ):
        (folder / "detail.json").write_text(json.dumps(record | change))
        with pytest.raises(BadInput, match=match):
            read_detail(folder)
    (folder / "detail.json").write_text("{")
    with pytest.raises(BadInput, match="not a JSON"):
        read_detail(folder)
