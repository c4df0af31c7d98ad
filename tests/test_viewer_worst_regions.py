"""Regions of registered scans, worst first."""

import json

import numpy as np
import pytest

from mien.errors import BadInput
from mien.faces import load_face
from mien.io.meshes import write_mesh
from mien.viewer.open_files import gather
from mien.viewer.worst_regions import read_regions

SHIFT = np.array([300.0, 0, 0])


@pytest.fixture
def registered(tmp_path):
    """Three scans with their record: the mouth of `smile` is worst, the chin of `frown` is called unreliable."""
    mesh = load_face().rig.neutral
    pose = {"rotation": np.eye(3).tolist(), "translation_mm": (-SHIFT).tolist(), "scale": 1.0}
    errors = {"calm": (0.01, 0.02), "smile": (0.05, 0.01), "frown": (0.02, 0.04)}
    scans = {}
    for name, (mouth, chin) in errors.items():
        write_mesh(tmp_path / f"{name}.ply", mesh.with_vertices(mesh.vertices + SHIFT))
        told = {"mouth": mouth, "chin": chin}
        unreliable = ["chin"] if name == "frown" else []
        scans[name] = {"T_face_scan": pose, "fine_error_per_mm": told, "unreliable": unreliable}
    record = tmp_path / "face.register.json"
    record.write_text(json.dumps({"scans": scans, "markers": {"resting": "calm"}}))
    return record


def test_what_is_unreliable_comes_first_then_the_largest_error(registered):
    regions = read_regions(registered)
    assert [(name, some[0].name) for name, some in regions.items()] == [
        ("frown", "chin"),
        ("smile", "mouth"),
        ("calm", "chin"),
    ]
    weight = load_face().regions["mouth"]
    middle = weight @ load_face().rig.neutral.vertices / weight.sum()
    np.testing.assert_allclose(regions["smile"][0].middle, middle + SHIFT, atol=0.01)


def test_beside_the_record_a_folder_stands_for_the_scans_to_mend(registered):
    shown, _ = gather([registered, registered.parent])
    assert [(one.name, one.regions[0].name) for one in shown] == [("frown.ply", "chin"), ("calm.ply", "chin")]
    chosen, _ = gather([registered, registered.parent / "smile.ply"])
    assert chosen[0].regions[0].name == "mouth"
    (registered.parent / "frown.ply").unlink()
    with pytest.raises(BadInput, match="holds no scan frown"):
        gather([registered, registered.parent])


@pytest.mark.parametrize("told", ["{", "[]", '{"scans": {"a": {}}}', '{"scans": {}, "markers": []}'])
def test_what_is_no_record_is_named(registered, told):
    registered.write_text(told)
    with pytest.raises(BadInput, match="no record of registered scans"):
        read_regions(registered)
