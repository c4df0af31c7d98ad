"""Record3D's files of all versions."""

import json
import zipfile

import lzfse
import numpy as np
import pytest
from PIL import Image

from mien.errors import BadInput
from mien.rgbd import read_rgbd
from mien.rgbd.record3d import depth_shape
from rgbd_takes import CAMERA, made


def record3d(path, depth_size=(24, 16), count=3):
    K = [60, 0, 0, 0, 61, 0, 23.5, 15.5, 1]
    about = {"w": 48, "h": 32, "dw": depth_size[0], "dh": depth_size[1], "fps": 20, "K": K}
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("metadata", json.dumps(about))
        for i, frame in enumerate(made(count)):
            with archive.open(f"rgbd/{i}.jpg", "w") as file:
                Image.fromarray(frame.color).save(file, "jpeg", quality=95)
            metres = np.full(depth_size[::-1], 0.5 + i, np.float32)
            archive.writestr(f"rgbd/{i}.depth", lzfse.compress(metres.tobytes()))


def test_record3d_brings_colour_and_depth_to_one_size(tmp_path):
    record3d(tmp_path / "a.r3d")
    take = read_rgbd(tmp_path / "a.r3d")
    frames = list(take)
    assert (take.camera, take.rate, len(take)) == (CAMERA, 20.0, 3)
    assert frames[1].depth.shape == (32, 48)
    np.testing.assert_array_equal(frames[1].depth, 1500)
    assert np.abs(frames[1].color.astype(int) - list(made())[1].color).mean() < 4


def test_record3d_of_older_versions_and_with_gaps(tmp_path):
    """No size of the depth, K in three lists, frame 1 without its depth."""
    record3d(tmp_path / "a.r3d")
    with zipfile.ZipFile(tmp_path / "a.r3d") as old, zipfile.ZipFile(tmp_path / "b.r3d", "w") as new:
        for name in old.namelist():
            if name not in ("metadata", "rgbd/1.depth"):
                new.writestr(name, old.read(name))
        K = [[60, 0, 23.5], [0, 61, 15.5], [0, 0, 1]]
        new.writestr("metadata", json.dumps({"w": 48, "h": 32, "K": K, "fps": 20}))
    take = read_rgbd(tmp_path / "b.r3d")
    frames = list(take)
    assert take.camera == CAMERA
    np.testing.assert_allclose([frame.time for frame in frames], [0, 0.1])
    np.testing.assert_array_equal(frames[1].depth, np.full((32, 48), 2500))
    assert "1 colour or depth images have no partner" in take.notes[0]
    assert depth_shape(192 * 256, 720, 960) == (192, 256)
    with pytest.raises(ValueError, match="do not make an image"):
        depth_shape(7919, 720, 960)


def test_record3d_without_depth_is_colour_alone(tmp_path):
    record3d(tmp_path / "a.r3d")
    with zipfile.ZipFile(tmp_path / "a.r3d") as old, zipfile.ZipFile(tmp_path / "b.r3d", "w") as new:
        for name in old.namelist():
            if not name.endswith(".depth"):
                new.writestr(name, old.read(name))
    take = read_rgbd(tmp_path / "b.r3d")
    assert not take.has_depth
    assert next(iter(take)).depth is None
    assert "no depth" in take.notes[0]


def repacked(path, name=lambda old: old, about=None, depth=lambda packed: packed):
    """`path` again as `odd.r3d`: other names, other metadata, depth packed otherwise."""
    odd = path.with_name("odd.r3d")
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(odd, "w") as new:
        for each in old.namelist():
            data = old.read(each)
            if each == "metadata":
                told = json.loads(data) if about is None else about
                data = json.dumps({key: value for key, value in told.items() if value is not None})
            new.writestr(name(each), depth(data) if each.endswith(".depth") else data)
    return odd


K = [60, 0, 0, 0, 61, 0, 23.5, 15.5, 1]
ABOUT = {"w": 48, "h": 32, "dw": 24, "dh": 16, "fps": 20, "K": K}
COEFFICIENTS = [[50, 51, 23.5, 15.5], [60, 61, 23.5, 15.5], [70, 71, 23.5, 15.5]]


@pytest.mark.parametrize(
    "odd",
    [
        {"name": lambda old: f"take/{old}"},
        {"name": lambda old: "metadata.json" if old == "metadata" else old.replace("rgbd/", "rgbd/00")},
        {"about": ABOUT | {"K": None, "perFrameIntrinsicCoeffs": COEFFICIENTS}},
        {"about": ABOUT | {"dw": 16, "dh": 24}},
        {"about": ABOUT | {"frameTimestamps": [7, 7, 7]}},
        {"depth": lzfse.decompress},
        {"depth": lambda data: np.frombuffer(lzfse.decompress(data), np.float32).astype(np.float16).tobytes()},
    ],
    ids=["in a folder", "other names", "lens by frame", "depth's sides swapped", "no clock", "bare", "half floats"],
)
def test_record3d_of_other_forms_is_the_same_take(tmp_path, odd):
    record3d(tmp_path / "a.r3d")
    take = read_rgbd(repacked(tmp_path / "a.r3d", **odd))
    frames = list(take)
    assert take.camera == CAMERA
    np.testing.assert_allclose([frame.time for frame in frames], [0, 0.05, 0.1])
    np.testing.assert_array_equal(frames[1].depth, np.full((32, 48), 1500))


@pytest.mark.parametrize(
    ("odd", "why"),
    [
        ({"name": lambda old: f"{old}x"}, "a zip, but not Record3D's: it holds no metadata, but metadatax, rgbd"),
        ({"name": lambda old: old.replace("jpg", "heic")}, "no colour as rgbd/0.jpg, but metadata, rgbd/0.depth"),
        ({"about": ABOUT | {"K": [0] * 9}}, "tells no camera"),
        ({"about": ABOUT | {"dw": 20}}, "frame 0 cannot be read .384 depths where its metadata says 20 x 16"),
        ({"depth": lambda data: b"nothing"}, "frame 0 cannot be read .its depth is damaged, or not packed by LZFSE"),
    ],
)
def test_record3d_is_refused_for_what_is_wrong_with_it(tmp_path, odd, why):
    record3d(tmp_path / "a.r3d")
    with pytest.raises(BadInput, match=why):
        list(read_rgbd(repacked(tmp_path / "a.r3d", **odd)))


def test_record3d_cut_off_or_not_one(tmp_path):
    record3d(tmp_path / "a.r3d")
    data = (tmp_path / "a.r3d").read_bytes()
    (tmp_path / "b.r3d").write_bytes(data[:-50])
    with pytest.raises(BadInput, match="not a whole Record3D recording"):
        read_rgbd(tmp_path / "b.r3d")
