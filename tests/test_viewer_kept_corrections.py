import json

import pytest

from mien.errors import BadInput
from mien.io.edits_file import edits_beside, read_layer
from mien.viewer.kept.corrections import STALE, Corrections

LAYER = {"keys": {"jawOpen": [{"time": 0.5, "add": 0.2}]}, "bad": []}


def save(corrections, layer):
    return corrections.save(json.dumps(layer).encode(), {"face": "0"})


def test_what_is_saved_is_read_back_and_counted(tmp_path):
    corrections = Corrections({0: tmp_path / "perf.glb"})
    assert json.loads(corrections.read({"face": "0"}).body) == {}
    assert json.loads(save(corrections, LAYER).body) == {"revision": 1, "file": "perf.edits.json"}
    assert json.loads(corrections.read({"face": "0"}).body) == LAYER | {"revision": 1}


def test_an_old_revision_is_refused_and_changes_nothing(tmp_path):
    corrections = Corrections({0: tmp_path / "perf.glb"})
    save(corrections, LAYER)
    answer = save(corrections, {"keys": {}})
    assert (answer.status, answer.body.decode()) == (409, STALE)
    assert read_layer(edits_beside(tmp_path / "perf.glb"))["keys"] == LAYER["keys"]


@pytest.mark.parametrize("asked", [{}, {"face": "1"}, {"face": "../0"}])
def test_only_faces_of_the_page_are_kept(tmp_path, asked):
    with pytest.raises(BadInput, match="there is none"):
        Corrections({0: tmp_path / "perf.glb"}).read(asked)


def test_what_is_no_layer_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no layer"):
        save(Corrections({0: tmp_path / "perf.glb"}), {"keys": {"jawOpen": [{"when": 1}]}})
