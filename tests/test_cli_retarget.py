"""`mien retarget` as a user runs it."""

import numpy as np
import pytest

from mien.cli.main import main
from mien.errors import BadInput
from mien.io.gltf import read_performance, write_performance, write_rig
from sheet_rigs import acting, remeshed


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
