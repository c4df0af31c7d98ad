"""A performance onto the rig of a file."""

import numpy as np

from gltf_files import performance, rig
from mien.cli.play import correspondence, play_on
from mien.io.gltf import read_performance, write_rig
from mien.rig import Rig


def test_one_topology_needs_no_correspondence():
    assert correspondence(rig(), rig()) == (None, "")


def test_a_rig_of_other_spellings_plays_and_what_was_assumed_is_told(tmp_path, capsys):
    names = ("Jaw_Open", "Cheek_Puff", "mouthSmile_L", "brow_inner_up")
    write_rig(tmp_path / "to.glb", Rig(rig().neutral, rig().deltas, names))
    given = performance()
    result, note = play_on(given, tmp_path / "to.glb", tmp_path / "out.glb", {})
    assert (len(result.moved), note) == (4, "")
    assert "4 shape names matched loosely" in capsys.readouterr().err
    back = read_performance(tmp_path / "out.glb")
    np.testing.assert_allclose(back.weights[:, : len(names)], np.clip(given.weights, 0, 1), atol=1e-5)
