"""Small good files of mien's own records, of OpenEXR and of RealSense, for the fuzz of readers."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from fuzz_seeds import LABELS, Reader, fresh, rig, surface

from mien.image_space.constraints import read_constraints
from mien.io.exr import read_exr, write_exr
from mien.io.meshes import write_mesh
from mien.landmarks.detector import COUNT
from mien.landmarks.on_rig import LandmarkMap
from mien.markers.attachment_file import read_attachment
from mien.rgbd import read_rgbd
from mien.scans.scan_files import match_scans
from mien.scans.scan_rig import read_scan_rig
from mien.scans.select.take_selection import read_selection

BARYCENTRIC = [0.2, 0.3, 0.5]


def record_readers(folder: Path) -> Iterator[Reader]:
    """Every reader of a record, its seed written under `folder`."""
    faces = len(surface().faces)
    attachment = {label: {"face": i, "barycentric": BARYCENTRIC} for i, label in enumerate(LABELS)}
    point = [[[1.0, 2, 3], [1, 2, 3]]]
    line = [[[0.0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0], [1, 1, 0]]]
    seeds = {
        "selection": ({"frames": [3, 0], "errors": [0.1, 0.05], "tolerance": 0.003, "take": "a.c3d"}, read_selection),
        "attachment": (attachment, lambda path: read_attachment(path, LABELS, faces)),
        "constraints": ({"pairs": [{"scans": ["a", "b"], "points": point, "curves": [line]}]}, read_constraints),
        "register": ({"markers": _markers_of_scans()}, lambda path: read_scan_rig(path, rig())),
        "landmarks": ({"landmarks": [[0, *BARYCENTRIC]] * (COUNT - 1) + [None]}, _read_landmarks),
    }
    for name, (content, read) in seeds.items():
        path = fresh(folder, f"{name}_json/{name}.json")
        path.write_text(json.dumps(content))
        yield Reader(f"{name}.json", (path,), read)
    yield _scans(folder)
    yield _exr(folder)
    yield from _bag(folder)


def _read_landmarks(path: Path) -> LandmarkMap:
    return LandmarkMap.load(path, surface())


def _markers_of_scans() -> dict:
    """What `mien register` writes of the markers on a rig of scans."""
    names = ("neutral", *rig().names)
    return {
        "resting": "neutral",
        "labels": list(LABELS),
        "attachment": [[i, *BARYCENTRIC] for i in range(len(LABELS))],
        "standoff_mm": [3.0] * len(LABELS),
        "on_skin": [True] * len(LABELS),
        "expressions_mm": {name: [[1.0, 2, 3]] * len(LABELS) for name in names},
    }


def _scans(folder: Path) -> Reader:
    """A folder of scans with the list that says whose frame each is."""
    scans = folder / "scans"
    scans.mkdir(parents=True)
    for name in ("a", "b"):
        write_mesh(scans / f"{name}.ply", surface())
    (scans / "scans.json").write_text(json.dumps({"a.ply": 0, "b.ply": 3}))
    return Reader("scans.json", (scans,), lambda path: match_scans(path, (0, 3)))


def _exr(folder: Path) -> Reader:
    path = fresh(folder, "exr/map.exr")
    write_exr(path, {name: np.arange(48, dtype=np.float32).reshape(6, 8) for name in "XYZ"})
    return Reader("map.exr", (path,), read_exr)


def _bag(folder: Path) -> Iterator[Reader]:
    """A RealSense recording of two frames; none where the package that writes it is missing."""
    try:
        from rosbags.rosbag1 import Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        return
    store = get_typestore(Stores.ROS1_NOETIC)
    kinds = store.types
    header = kinds["std_msgs/msg/Header"](0, kinds["builtin_interfaces/msg/Time"](0, 0), "0")
    region = kinds["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    K = np.array([20.0, 0, 8, 0, 20, 6, 0, 0, 1])
    info_kind, image_kind = "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/Image"
    info = kinds[info_kind](header, 12, 16, "", np.zeros(5), K, np.eye(3).ravel(), np.zeros(12), 0, 0, region)
    still = kinds["geometry_msgs/msg/Vector3"](0, 0, 0), kinds["geometry_msgs/msg/Quaternion"](0, 0, 0, 1)
    move = kinds["geometry_msgs/msg/Transform"](*still)
    unit = kinds["std_msgs/msg/Float32"](0.001)
    grey = kinds[image_kind](header, 12, 16, "mono16", 0, 32, np.full(192, 600, np.uint16).view(np.uint8))
    rgb = kinds[image_kind](header, 12, 16, "rgb8", 0, 48, np.full(576, 90, np.uint8))
    depth, color = "/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0"
    sent = [
        (f"{depth}/info/camera_info", info_kind, info), (f"{color}/info/camera_info", info_kind, info),
        ("/device_0/sensor_0/option/Depth Units/value", "std_msgs/msg/Float32", unit),
        (f"{depth}/tf/0", "geometry_msgs/msg/Transform", move), (f"{color}/tf/0", "geometry_msgs/msg/Transform", move),
        (f"{depth}/image/data", image_kind, grey), (f"{color}/image/data", image_kind, rgb),
    ]  # fmt: skip
    path = fresh(folder, "realsense/take.bag")
    with Writer(path) as writer:
        for topic, kind, message in sent:
            connection = writer.add_connection(topic, kind, typestore=store)
            writer.write(connection, 0, store.serialize_ros1(message, kind))
    yield Reader("take.bag", (path,), lambda path: list(read_rgbd(path)))
