"""Animation in glTF."""

import json

import numpy as np
import pytest

from gltf_files import cap, f32, foreign, performance
from mien.io.gltf import read_performance, write_performance
from mien.io.gltf.glb import GlbBuilder, open_glb
from mien.rig import Performance, Rig
from mien.transforms import Transform


@pytest.mark.parametrize("frames", [1, 2])
def test_very_short_performance(tmp_path, frames):
    before = performance(frames=30)
    few = Performance(before.rig, before.weights[:frames], before.T_world_face[:frames], 59.94, np.ones(frames, bool))
    write_performance(tmp_path / "perf.glb", few)
    after = read_performance(tmp_path / "perf.glb")
    np.testing.assert_allclose(after.weights, few.weights, atol=1e-7)
    assert after.rate == 59.94


def test_a_long_performance_keeps_its_frames(tmp_path):
    """float32 times half an hour in are coarse; frames must neither be lost nor doubled."""
    frames = 100_000
    face = Rig(cap(3), np.zeros((1, 10, 3)), ("jawOpen",))
    weights = np.linspace(0, 1, frames)[:, None]
    take = Performance(face, weights, Transform.identity(frames), 59.94, np.ones(frames, bool))
    write_performance(tmp_path / "p.glb", take)
    np.testing.assert_allclose(read_performance(tmp_path / "p.glb").weights, weights, atol=1e-6)


def test_uneven_keys_are_resampled(tmp_path):
    build = GlbBuilder(json=json.loads(json.dumps(open_glb(foreign(tmp_path / "x.glb", animate=False)).json)))
    build._blob += open_glb(tmp_path / "x.glb").blob
    times = build.accessor(f32([1.0, 1.1, 1.2, 1.5]), bounds=True)
    weights = build.accessor(f32([0, 0, 1, 0, 0, 0, 0.3, 0]))
    build.add(
        "animations",
        {
            "samplers": [{"input": times, "output": weights}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "weights"}}],
        },
    )
    build.save(tmp_path / "uneven.glb")
    read = read_performance(tmp_path / "uneven.glb")
    assert read.rate == 10
    np.testing.assert_allclose(read.weights[:, 0], [0, 1, 0, 0.1, 0.2, 0.3], atol=1e-5)
