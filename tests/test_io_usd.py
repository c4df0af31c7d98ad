"""USD out and in: nothing is lost, and USD's own validators have nothing to say."""


import numpy as np
import pytest

from gltf_files import refusal, same_rig
from mien.errors import BadInput
from mien.io import usd
from usd_files import complaints, foreign, performance, rig


@pytest.mark.parametrize("suffix", usd.SUFFIXES)
def test_a_performance_comes_back_whole(tmp_path, suffix):
    play, path = performance(), tmp_path / f"a{suffix}"
    usd.write_performance(path, play)
    back = usd.read_performance(path)
    same_rig(back.rig, play.rig)
    assert back.rate == play.rate
    np.testing.assert_allclose(back.weights, play.weights, atol=1e-7)
    np.testing.assert_allclose(back.T_world_face.rotation, play.T_world_face.rotation, atol=1e-6)
    np.testing.assert_allclose(back.T_world_face.translation, play.T_world_face.translation, atol=1e-4)
    np.testing.assert_array_equal(back.tracked, play.tracked)
    np.testing.assert_array_equal(back.rig.texture, play.rig.texture)
    np.testing.assert_array_equal(back.rig.neutral.uv_faces, play.rig.neutral.uv_faces)
    np.testing.assert_allclose(back.rig.neutral.uv, play.rig.neutral.uv, atol=1e-7)
    assert complaints(path) == []


def test_a_rig_comes_back_whole(tmp_path):
    usd.write_rig(tmp_path / "a.usdc", rig())
    same_rig(usd.read_rig(tmp_path / "a.usdc"), rig())
    assert complaints(tmp_path / "a.usdc") == []
    assert "rig, not a performance" in refusal(usd.read_performance, tmp_path / "a.usdc")
    assert not usd.is_animated(tmp_path / "a.usdc")


def test_weights_beyond_one_are_split_and_joined(tmp_path):
    play = performance()
    play.weights[3, 0], play.weights[4, 2] = 1.7, -0.4
    usd.write_performance(tmp_path / "a.usdc", play)
    back = usd.read_performance(tmp_path / "a.usdc")
    assert back.rig.names == play.rig.names
    np.testing.assert_allclose(back.weights, play.weights, atol=1e-6)


def test_what_is_no_rig_is_told(tmp_path):
    assert "no such file" in refusal(usd.read_rig, tmp_path / "none.usd")
    (tmp_path / "a.usda").write_text("#usda 1.0\ndef Mesh")
    assert "no valid USD" in refusal(usd.read_rig, tmp_path / "a.usda")
    (tmp_path / "b.usda").write_text("#usda 1.0\n")
    assert "no blend shapes" in refusal(usd.read_rig, tmp_path / "b.usda")
    foreign(tmp_path / "c.usda", **{"pointIndices = [2]": "pointIndices = [9]"})
    assert "blend shape smile has offsets for other vertices" in refusal(usd.read_rig, tmp_path / "c.usda")


@pytest.mark.parametrize("suffix", [".usdc", ".usda", ".usdz"])
def test_damage_is_told_or_harmless(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    usd.write_performance(path, performance())
    data = path.read_bytes()
    rng = np.random.default_rng(0)
    told = []
    for _ in range(12):
        damaged = np.frombuffer(data, np.uint8).copy()
        damaged[rng.integers(0, len(data), 6)] = rng.integers(0, 256, 6)
        path.write_bytes(damaged[: rng.integers(len(data) // 4, len(data) + 1)].tobytes())
        try:
            read = usd.read_performance if usd.is_animated(path) else usd.read_rig
            read(path)
        except BadInput as error:
            told.append(str(error))
    assert told
    assert not any("\n" in line for line in told)
