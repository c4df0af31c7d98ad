"""`mien retarget` as a user runs it."""

import numpy as np
import pytest

from command import mien
from mien.cli.main import main
from mien.errors import BadInput
from mien.io.gltf import read_performance, write_performance, write_rig
from mien.rig import Rig
from sheet_rigs import acting, performed, remeshed, sheet


def test_from_the_shell_a_target_that_shows_no_face_is_still_driven_and_told_of(tmp_path, monkeypatch, capsys):
    def blind(*_):
        raise BadInput("the rig does not look like a face")

    write_performance(tmp_path / "perf.glb", acting())
    write_rig(tmp_path / "other.glb", remeshed()[0])
    monkeypatch.setattr("mien.cli.play.match_faces", blind)
    words = ["retarget", str(tmp_path / "perf.glb"), "--to", str(tmp_path / "other.glb"), "-o", str(tmp_path / "o.glb")]
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code in (0, None)
    told = capsys.readouterr().out
    assert "52 shapes and 1 correctives" in told
    assert "nearest points alone (the rig does not look like a face)" in told
    out = read_performance(tmp_path / "o.glb")
    assert len(out.rig.neutral.faces) == 9000
    np.testing.assert_allclose(out.T_world_face.translation, acting().T_world_face.translation, atol=1e-3)


def test_an_option_that_does_nothing_is_refused(tmp_path):
    mesh = sheet(6)
    rig = Rig(mesh, np.ones((1, *mesh.vertices.shape)), ("jawOpen",))
    write_performance(tmp_path / "perf.glb", performed(rig, np.zeros((2, 1))))
    write_rig(tmp_path / "other.glb", rig)
    with pytest.raises(BadInput, match="--correctives does nothing for a performance without correctives"):
        mien("retarget", tmp_path / "perf.glb", to=tmp_path / "other.glb", output=tmp_path / "o.glb", correctives=False)
    assert not (tmp_path / "o.glb").exists()
