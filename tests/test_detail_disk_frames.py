import numpy as np
import pytest

from detail_patch import training
from mien.detail.base_mesh import BaseConfig
from mien.detail.disk.frames import normal_image, write_frames
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


def test_a_slope_tilts_the_normal_map_by_its_angle():
    """A height that grows by a tenth of a millimetre a millimetre along u, and one that does along v."""
    still = BaseConfig(vertices=0, smoothing_mm=0)
    model = fit_detail(training(), DetailConfig(base=still, medium_size=16, fine_size=64))
    rows, columns = np.mgrid[:64, :64]
    side = 60.0 / 0.9 / 64
    middle = (slice(28, 36), slice(31, 33))
    along_u = normal_image(model, (0.1 * side * columns).astype(np.float32))[middle] / 127.5 - 1
    along_v = normal_image(model, (-0.1 * side * rows).astype(np.float32))[middle] / 127.5 - 1
    np.testing.assert_allclose(along_u[..., 0], -0.1, atol=0.015)
    np.testing.assert_allclose(along_v[..., 1], -0.1, atol=0.015)
    np.testing.assert_allclose(along_u[..., 1], 0, atol=0.01)
