"""RealSense bags."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rgbd import read_rgbd
from rgbd_takes import CAMERA, made


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
