import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.frames import write_frames
from mien.detail.drive import Drive
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.synthesize import SynthesisConfig, Synthesizer
from mien.errors import BadInput
from mien.io.meshes.ply import read_ply
from mien.transforms import Transform


def test_frames_stand_where_the_head_was(tmp_path):
    model = fit_detail(training(), DetailConfig(base=BaseConfig(vertices=0), medium_size=16, fine_size=0))
    synthesizer = Synthesizer(model, SynthesisConfig())
    away = Transform(np.tile(np.eye(3), (2, 1, 1)), np.array([[0.0, 0, 0], [100, 0, 0]]))
    drive = Drive(np.stack([model.reference] * 2), away, np.zeros(25))
    assert write_frames(tmp_path / "out", synthesizer, drive, synthesizer.frames(drive.positions)) == 2
    first, second = (read_ply(tmp_path / "out" / f"frame_{i:06d}.ply")[0].vertices for i in (0, 1))
    np.testing.assert_allclose(second - first, np.tile([100.0, 0, 0], (len(first), 1)), atol=1e-3)
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="a file"):
        write_frames(tmp_path / "file", synthesizer, drive, iter(()))
