"""RGB-D takes: every kind of file in, and what is said of bad ones."""

import json
import threading
import time
import zipfile
from dataclasses import replace

import av
import lzfse
import numpy as np
import pytest
from PIL import Image

from mien._kernels import track_depth, track_depth_twin
from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.errors import BadInput
from mien.io.rgbd import RgbdTake, read_intrinsics, read_rgbd, write_intrinsics, write_rgbd
from mien.io.rgbd.display_matrix import turned
from mien.io.rgbd.live import Replay, live_frames
from mien.io.rgbd.record3d import depth_shape
from mien.io.rgbd.webcam import Webcam, open_webcam
from mien.transforms import rotation_from_vector

CAMERA = Camera(60.0, 61.0, 23.5, 15.5, 48, 32)


def made(count=4, rate=20.0):
    """A take in memory: smooth colour that a video codec keeps, depth with holes."""
    y, x = np.mgrid[:32, :48]

    def frames():
        for i in range(count):
            color = np.stack([5 * x, 7 * y, np.full_like(x, 20 * i)], -1).astype(np.uint8)
            depth = (600 + 3 * x + y + i).astype(np.float32)
            depth[:4] = 0
            yield RGBDFrame(color, depth, i / rate)

    return RgbdTake("made", CAMERA, rate, count, True, frames)


@pytest.fixture
def folder(tmp_path):
    write_rgbd(tmp_path / "take", made())
    return tmp_path / "take"


def same(found, expected, tolerance=0.0):
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_array_equal(a.color, b.color)
        np.testing.assert_allclose(a.depth, b.depth, atol=tolerance)
        assert a.time == pytest.approx(b.time, abs=1e-6)


def test_folder_comes_back_as_written_and_can_be_walked_twice(folder):
    take = read_rgbd(folder)
    assert (take.camera, take.rate, len(take), take.has_depth) == (CAMERA, 20.0, 4, True)
    same(take, made())
    same(take, made())


def test_depth_scale_is_units_a_metre(tmp_path):
    write_rgbd(tmp_path / "fine", made(), depth_scale=5000.0)
    same(read_rgbd(tmp_path / "fine"), made(), tolerance=0.11)
    wrong = next(iter(read_rgbd(tmp_path / "fine", depth_scale=1000.0))).depth
    np.testing.assert_allclose(wrong, 5 * next(iter(made())).depth, atol=0.6)


def test_depth_that_does_not_fit_sixteen_bits_is_refused(tmp_path):
    with pytest.raises(BadInput, match="lower depth_scale"):
        write_rgbd(tmp_path / "deep", made(), depth_scale=1e6)


def test_intrinsics_are_open3d_s_column_by_column(tmp_path):
    write_intrinsics(tmp_path / "c.json", CAMERA)
    matrix = np.reshape(json.loads((tmp_path / "c.json").read_text())["intrinsic_matrix"], (3, 3)).T
    np.testing.assert_array_equal(matrix, [[60, 0, 23.5], [0, 61, 15.5], [0, 0, 1]])
    assert read_intrinsics(tmp_path / "c.json") == CAMERA


def test_missing_and_broken_intrinsics(folder):
    (folder / "camera_intrinsic.json").write_text('{"width": 4}')
    with pytest.raises(BadInput, match="needs width, height and intrinsic_matrix"):
        read_rgbd(folder)
    (folder / "camera_intrinsic.json").unlink()
    with pytest.raises(BadInput, match="intrinsics are missing"):
        read_rgbd(folder)


def test_images_are_paired_by_number_not_by_order(folder):
    """Equal counts, but each stream lost another frame."""
    (folder / "color" / "000001.png").unlink()
    (folder / "depth" / "000002.png").unlink()
    (folder / "timestamps.csv").unlink()
    take = read_rgbd(folder)
    before = list(made())
    same(list(take), [before[0], before[3]])
    assert take.notes[0].endswith("1 colour and 1 depth images have no partner and are left out; 2 pairs remain")


def test_names_that_differ_are_paired_by_their_numbers(folder):
    for i, file in enumerate(sorted((folder / "depth").iterdir())):
        file.rename(folder / "depth" / f"depth_{i}.png")
    take = read_rgbd(folder)
    same(list(take), list(made()))
    assert take.notes == ()


def test_stamps_are_paired_with_the_nearest(folder):
    for kind, shift in (("color", 0.0), ("depth", 0.004)):
        for i, file in enumerate(sorted((folder / kind).iterdir())):
            file.rename(folder / kind / f"{1305031102.1 + i / 20 + shift:.6f}.png")
    (folder / "timestamps.csv").unlink()
    (folder / "depth" / "1305031102.154000.png").unlink()
    take = read_rgbd(folder)
    before = list(made())
    same(list(take), [before[0], before[2], before[3]], 1e-4)


def test_without_a_common_number_order_decides_and_a_line_says_so(folder):
    for i, file in enumerate(sorted((folder / "depth").iterdir())):
        file.rename(folder / "depth" / f"{i + 100}.png")
    assert "paired by order" in read_rgbd(folder).notes[0]
    (folder / "depth" / "100.png").unlink()
    with pytest.raises(BadInput, match="4 colour and 3 depth images"):
        read_rgbd(folder)


def test_sizes_of_one_view_are_brought_together_and_others_refused(folder):
    before, first = read_rgbd(folder), next(iter(read_rgbd(folder)))
    for file in (folder / "color").iterdir():
        Image.open(file).resize((96, 64)).save(file)
    take = read_rgbd(folder)
    assert "colour 96 x 64, depth 48 x 32" in take.notes[0]
    assert take.camera == before.camera.scaled(2)
    np.testing.assert_array_equal(next(iter(take)).depth[::2, ::2], first.depth)
    for file in (folder / "color").iterdir():
        Image.open(file).resize((96, 96)).save(file)
    with pytest.raises(BadInput, match="colour 96 x 96, depth 48 x 32"):
        read_rgbd(folder)


@pytest.mark.parametrize(
    "content",
    [
        {"width": 48, "height": 32, "intrinsic_matrix": [60, 0, 23.5, 0, 61, 15.5, 0, 0, 1]},
        {"width": 48, "height": 32, "intrinsic_matrix": [[60, 0, 23.5], [0, 61, 15.5], [0, 0, 1]]},
        {"width": 48, "height": 32, "intrinsic_matrix": [[60, 0, 0], [0, 61, 0], [23.5, 15.5, 1]]},
        {"fx": 60, "fy": 61, "ppx": 23.5, "ppy": 15.5},
        {"camera_matrix": {"data": [60, 0, 23.5, 0, 61, 15.5, 0, 0, 1]}},
    ],
)
def test_intrinsics_in_other_forms(folder, content):
    (folder / "camera_intrinsic.json").write_text(json.dumps(content))
    assert read_rgbd(folder).camera == CAMERA


@pytest.mark.parametrize(
    "text",
    [
        "timestamp_ms;frame\n1000;0\n1100;1\n1150;2\n1300;3\n",
        "0 5000000000\n1 5100000000\n2 5150000000\n3 5300000000\n",
        "filename,time\n000000.png,1.0\n000001.png,1.1\n000002.png,1.15\n000003.png,1.3\n",
    ],
)
def test_clocks_of_other_recorders(folder, text):
    (folder / "timestamps.csv").write_text(text)
    np.testing.assert_allclose([frame.time for frame in read_rgbd(folder)], [0, 0.1, 0.15, 0.3], atol=1e-6)


def test_display_matrices_by_hand():
    image = np.arange(6, dtype=np.uint8).reshape(2, 3, 1).repeat(3, 2)
    shown = {m: turned(image, np.reshape(m, (2, 2)))[..., 0].tolist() for m in [
        (1, 0, 0, 1), (0, 1, -1, 0), (-1, 0, 0, -1), (0, -1, 1, 0), (-1, 0, 0, 1), (0, 1, 1, 0)]}  # fmt: skip
    assert shown[1, 0, 0, 1] == [[0, 1, 2], [3, 4, 5]]
    assert shown[0, 1, -1, 0] == [[3, 0], [4, 1], [5, 2]]
    assert shown[-1, 0, 0, -1] == [[5, 4, 3], [2, 1, 0]]
    assert shown[0, -1, 1, 0] == [[2, 5], [1, 4], [0, 3]]
    assert shown[-1, 0, 0, 1] == [[2, 1, 0], [5, 4, 3]]
    assert shown[0, 1, 1, 0] == [[0, 3], [1, 4], [2, 5]]


def test_a_take_cut_off_in_a_frame_gives_the_frames_before(folder):
    file = folder / "depth" / "000002.png"
    file.write_bytes(file.read_bytes()[:-400])
    frames, seen = iter(read_rgbd(folder)), []
    seen += [next(frames), next(frames)]
    with pytest.raises(BadInput, match=r"000002.png: cannot be read to its end"):
        seen.extend(frames)
    same(seen, list(made())[:2])


def test_bad_depth_images_settings_and_clock(folder):
    (folder / "timestamps.csv").write_text("frame,seconds\n0,0\n1,0.2\n2,0.1\n3,0.4\n")
    with pytest.raises(BadInput, match="seconds must grow; they do not after frame 1"):
        read_rgbd(folder)
    (folder / "timestamps.csv").write_text("a,b\n")
    with pytest.raises(BadInput, match="needs columns frame,seconds"):
        read_rgbd(folder)
    (folder / "timestamps.csv").unlink()
    (folder / "take.json").write_text('{"fps": 0}')
    with pytest.raises(BadInput, match="fps must be above 0"):
        read_rgbd(folder)
    (folder / "take.json").unlink()
    Image.fromarray(np.zeros((32, 48), np.uint8)).save(folder / "depth" / "000000.png")
    with pytest.raises(BadInput, match="must be a 16-bit grey PNG"):
        list(read_rgbd(folder))


def test_what_is_no_take_is_refused(tmp_path):
    (tmp_path / "a.txt").write_text("x")
    with pytest.raises(BadInput, match="not a take; give"):
        read_rgbd(tmp_path / "a.txt")
    with pytest.raises(BadInput, match="no images either"):
        read_rgbd(tmp_path)
    with pytest.raises(BadInput, match="no such file"):
        read_rgbd(tmp_path / "nothing")


def test_images_alone_are_a_take_without_depth(folder):
    for file in (folder / "depth").iterdir():
        file.unlink()
    (folder / "depth").rmdir()
    take = read_rgbd(folder, rate=10.0)
    assert (take.has_depth, take.rate, take.camera, take.guessed_camera) == (False, 10, CAMERA, False)
    assert all(frame.depth is None for frame in take)
    loose = read_rgbd(folder / "color", focal=50.0)
    assert loose.camera == Camera(50.0, 50.0, 23.5, 15.5, 48, 32)


def test_video_alone_assumes_sixty_degrees(tmp_path):
    path = tmp_path / "clip.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = 48, 32, "yuv420p"
        for frame in made(5):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(frame.color, format="rgb24")))
        container.mux(stream.encode(None))
    take = read_rgbd(path)
    frames = list(take)
    assert (len(frames), take.count, take.rate, take.has_depth, take.guessed_camera) == (5, 5, 25.0, False, True)
    assert take.camera.fx == pytest.approx(24 / np.tan(np.radians(30)))
    np.testing.assert_allclose([f.time for f in frames], np.arange(5) / 25, atol=1e-3)
    assert np.abs(frames[2].color.astype(int) - list(made(5))[2].color).mean() < 6


def test_a_file_that_is_no_video(tmp_path):
    (tmp_path / "a.mp4").write_bytes(b"no")
    with pytest.raises(BadInput, match="no video that can be read"):
        read_rgbd(tmp_path / "a.mp4")


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


def test_record3d_cut_off_or_not_one(tmp_path):
    record3d(tmp_path / "a.r3d")
    data = (tmp_path / "a.r3d").read_bytes()
    (tmp_path / "b.r3d").write_bytes(data[:-50])
    with pytest.raises(BadInput, match="not a whole Record3D recording"):
        read_rgbd(tmp_path / "b.r3d")


def bag(path, count=3):
    """A RealSense-like recording: 0.5 mm units, the depth camera 20 mm to the left of colour."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    header = types["std_msgs/msg/Header"](0, types["builtin_interfaces/msg/Time"](0, 0), "0")
    region = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    K = np.array([60.0, 0, 23.5, 0, 61.0, 15.5, 0, 0, 1])
    info = types["sensor_msgs/msg/CameraInfo"](
        header, 32, 48, "", np.zeros(5), K, np.eye(3).ravel(), np.zeros(12), 0, 0, region
    )
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    move = types["geometry_msgs/msg/Transform"]
    with Writer(path) as writer:

        def send(topic, kind, message, stamp=0):
            known = [c for c in writer.connections if c.topic == topic]
            connection = known[0] if known else writer.add_connection(topic, kind, typestore=store)
            writer.write(connection, stamp, store.serialize_ros1(message, kind))

        base = "/device_0/sensor_"
        send(base + "0/Depth_0/info/camera_info", "sensor_msgs/msg/CameraInfo", info)
        send(base + "1/Color_0/info/camera_info", "sensor_msgs/msg/CameraInfo", info)
        send(base + "0/option/Depth Units/value", "std_msgs/msg/Float32", types["std_msgs/msg/Float32"](0.0005))
        send(base + "0/Depth_0/tf/0", "geometry_msgs/msg/Transform", move(vector(0, 0, 0), turn(0, 0, 0, 1)))
        send(base + "1/Color_0/tf/0", "geometry_msgs/msg/Transform", move(vector(0.02, 0, 0), turn(0, 0, 0, 1)))
        image = types["sensor_msgs/msg/Image"]
        for i, frame in enumerate(made(count)):
            stamp = int(i * 5e7)
            depth = np.full((32, 48), 1200, np.uint16)
            grey = image(header, 32, 48, "mono16", 0, 96, depth.view(np.uint8).ravel())
            rgb = image(header, 32, 48, "rgb8", 0, 144, frame.color.ravel())
            send(base + "0/Depth_0/image/data", "sensor_msgs/msg/Image", grey, stamp)
            send(base + "1/Color_0/image/data", "sensor_msgs/msg/Image", rgb, stamp + 1_000_000)


def test_realsense_depth_is_registered_to_colour(tmp_path):
    bag(tmp_path / "a.bag")
    take = read_rgbd(tmp_path / "a.bag")
    frames = list(take)
    assert (take.camera, len(take), len(frames)) == (CAMERA, 3, 3)
    np.testing.assert_array_equal(frames[2].color, list(made())[2].color)
    # A plane at 600 mm seen from 20 mm to the right: everything moves 60 * 20 / 600 = 2 pixels to the left.
    assert (frames[0].depth[:, :46] == 600).all()
    assert (frames[0].depth[:, 46:] == 0).all()
    np.testing.assert_allclose([f.time for f in frames], [0, 0.05, 0.1], atol=1e-6)


def test_a_file_that_is_no_bag(tmp_path):
    (tmp_path / "a.bag").write_bytes(b"#ROSBAG V2.0\n" + b"x" * 200)
    with pytest.raises(BadInput, match="not a whole RealSense recording"):
        read_rgbd(tmp_path / "a.bag")


def test_register_depth_agrees_with_its_twin():
    rng = np.random.default_rng(0)
    depth = rng.uniform(500, 700, (20, 30)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = 0
    R, t = rotation_from_vector(np.array([0.02, -0.05, 0.03])), np.array([12.0, -5.0, 3.0])
    arguments = (depth, np.array([40.0, 40, 15, 10]), R, t, np.array([65.0, 65, 24, 16]), 32, 48)
    fast, plain = (module.register_depth(*arguments) for module in (track_depth, track_depth_twin))
    np.testing.assert_allclose(fast, plain, rtol=1e-6)


class Clock:
    """Time that passes only in sleep, or when somebody works."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def test_replay_keeps_the_clock_and_drops_what_nobody_waited_for():
    clock = Clock()
    source = Replay(made(10, rate=10.0), clock=clock, sleep=clock.sleep)
    seen = []
    for frame in live_frames(source):
        seen.append((round(frame.time, 3), round(clock.now - 100, 3)))
        clock.now += 0.25 if len(seen) == 2 else 0.01
    assert [t for t, _ in seen] == [0.0, 0.1, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]
    assert source.missed == 1
    assert all(now >= t - 1e-9 for t, now in seen)


def test_replay_at_double_speed():
    clock = Clock()
    times = [clock.now for _ in live_frames(Replay(made(5, rate=10.0), speed=2.0, clock=clock, sleep=clock.sleep))]
    np.testing.assert_allclose(times[-1] - 100, 0.2)
    with pytest.raises(ValueError, match="speed: expected above 0"):
        Replay(made(), speed=0.0)


def test_empty_take_is_refused(tmp_path):
    empty = replace(made(), count=0, frames=lambda: iter(()))
    write_rgbd(tmp_path / "empty", empty)
    with pytest.raises(BadInput, match="no images either"):
        read_rgbd(tmp_path / "empty")


def test_jpeg_colour_is_nearly_the_same_and_an_older_take_is_replaced(folder):
    write_rgbd(folder, made(2), color="jpg")
    take = read_rgbd(folder)
    assert len(take) == 2
    for found, expected in zip(take, made(2), strict=True):
        np.testing.assert_array_equal(found.depth, expected.depth)
        assert np.abs(found.color.astype(int) - expected.color).mean() < 6


def test_a_folder_says_with_which_scale_it_was_read(folder):
    assert read_rgbd(folder).depth_scale == 1000
    assert read_rgbd(folder, depth_scale=250.0).depth_scale == 250


def test_a_webcam_gives_the_newest_picture_once_and_ends_with_the_last():
    pictures, go = [np.full((2, 2, 3), i, np.uint8) for i in range(5)], threading.Event()

    def stream():
        yield from pictures[:3]
        go.wait(5)
        yield from pictures[3:]

    camera = Webcam(stream(), CAMERA, 30.0, seconds=60.0)
    time.sleep(0.1)
    first = camera.latest()
    go.set()
    seen = [frame.color[0, 0, 0] for frame in live_frames(camera)]
    assert first.color[0, 0, 0] == 2
    assert first.depth is None
    assert seen[-1] == 4
    assert len(seen) <= 2
    assert camera.latest() is None


def test_a_webcam_stops_after_its_time():
    def endless():
        while True:
            time.sleep(0.01)
            yield np.zeros((2, 2, 3), np.uint8)

    times = [frame.time for frame in live_frames(Webcam(endless(), CAMERA, 100.0, seconds=0.1))]
    assert len(times) >= 2
    assert times[-1] < 0.1
    assert (np.diff(times) > 0).all()


def test_no_camera_is_said_in_one_line():
    with pytest.raises(BadInput, match=r"/dev/nothing: no camera to be opened .*--device"):
        open_webcam(1.0, "/dev/nothing")
    with pytest.raises(BadInput, match="seconds: expected above 0, got 0"):
        open_webcam(0.0)
