"""RealSense recordings (`.bag`, ROS 1): depth is registered to colour here, since the camera records it raw."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from .._kernels import track_depth
from ..camera import Camera
from ..depth import RGBDFrame
from ..errors import BadInput
from ..extras import require
from ..transforms import Transform
from .take import RgbdTake

DEPTH_UNIT = 0.001
"""Metres in one unit of depth where the recording does not say."""


@dataclass(frozen=True)
class _Bag:
    """What is read of a recording before its images."""

    color: Camera
    depth: Camera
    T_color_depth: Transform
    unit: float
    """Metres."""
    count: int
    rate: float


def read_realsense(path: Path) -> RgbdTake:
    """Open a RealSense recording.

    A depth frame goes with the colour frame that is nearest to it in time, no farther than half a frame. The
    recording's `tf` topics are read as transforms from a stream to the reference stream.

    Raises:
        BadInput: no such recording, without depth or colour, or the extra `realsense` is missing.
    """
    bag = _about(path)

    def frames() -> Iterator[RGBDFrame]:
        with _reader(path) as reader:
            yield from _frames(path, reader, bag)

    return RgbdTake(path.name, bag.color, bag.rate, bag.count, True, frames)


def _about(path: Path) -> _Bag:
    with _reader(path) as reader:
        infos = {kind: _last(reader, rf"/{kind}_0/info/camera_info$") for kind in ("Depth", "Color")}
        images = {kind: _topics(reader, rf"/{kind}_0/image/data$") for kind in ("Depth", "Color")}
        for kind, told in (("Depth", "depth"), ("Color", "colour")):
            if infos[kind] is None or not images[kind]:
                raise BadInput(f"{path}: has no {told} stream; record depth and colour together")
        unit = _last(reader, r"/option/Depth[_ ]Units/value$")
        T_ref = {kind: _transform(_last(reader, rf"/{kind}_0/tf/0$")) for kind in infos}
        count = sum(c.msgcount for c in images["Color"])
        seconds = reader.duration * 1e-9
    color, depth = (_camera(infos[kind]) for kind in ("Color", "Depth"))
    rate = float(round((count - 1) / seconds)) if count > 1 and seconds > 0 else 30.0
    metres = DEPTH_UNIT if unit is None else float(unit.data)
    return _Bag(color, depth, T_ref["Color"].inverse() @ T_ref["Depth"], metres, count, max(rate, 1.0))


def _frames(path: Path, reader, bag: _Bag) -> Iterator[RGBDFrame]:
    """Colour frames in order, each with the nearest depth."""
    streams = [*_topics(reader, r"/Depth_0/image/data$"), *_topics(reader, r"/Color_0/image/data$")]
    depth, waiting, start = None, None, -1
    try:
        for connection, stamp, raw in reader.messages(connections=streams):
            message = reader.deserialize(raw, connection.msgtype)
            if "/Depth_0/" in connection.topic:
                depth = (stamp, message)
                if waiting is not None:
                    yield _pair(waiting, depth, bag, start)
                    waiting = None
                continue
            start = stamp if start < 0 else start
            if waiting is not None:
                yield _pair(waiting, depth, bag, start)
            waiting = (stamp, message)
            if depth is not None and abs(depth[0] - stamp) < 0.25e9 / bag.rate:
                yield _pair(waiting, depth, bag, start)
                waiting = None
    except BadInput:
        raise
    except Exception as error:
        why = next(iter(str(error).splitlines()), type(error).__name__)
        raise BadInput(f"{path}: breaks off ({why}); the recording was cut off there") from error
    if waiting is not None:
        yield _pair(waiting, depth, bag, start)


def _pair(color, depth, bag: _Bag, start: int) -> RGBDFrame:
    stamp, message = color
    image = _pixels(message, 3)
    image = image[..., ::-1] if message.encoding.startswith("bgr") else image
    time = (stamp - start) * 1e-9
    if depth is None or abs(depth[0] - stamp) > 0.75e9 / bag.rate:
        empty = np.zeros(image.shape[:2], np.float32)
        return RGBDFrame(np.ascontiguousarray(image), empty, time)
    raw = _pixels(depth[1], 1).astype(np.float32) * np.float32(bag.unit * 1000)
    T = bag.T_color_depth
    registered = track_depth.register_depth(
        raw, _intrinsics(bag.depth), T.rotation, T.translation, _intrinsics(bag.color), *image.shape[:2]
    )
    return RGBDFrame(np.ascontiguousarray(image), registered, time)


def _pixels(message, channels: int) -> np.ndarray:
    kind = np.uint8 if channels == 3 else np.uint16
    known = ("rgb8", "bgr8") if channels == 3 else ("mono16", "16UC1")
    if message.encoding not in known:
        raise BadInput(f"images are {message.encoding}, not {' or '.join(known)}; record in that format")
    flat = np.frombuffer(message.data.tobytes(), kind)
    image = flat.reshape(message.height, message.step // (channels * np.dtype(kind).itemsize), channels)
    image = image[:, : message.width]
    return image if channels == 3 else image[..., 0]


def _intrinsics(camera: Camera) -> np.ndarray:
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy])


def _camera(info) -> Camera:
    K = np.asarray(info.K if hasattr(info, "K") else info.k, float)
    return Camera(K[0], K[4], K[2], K[5], int(info.width), int(info.height))


def _transform(message) -> Transform:
    """A geometry_msgs/Transform in mm; the identity where there is none."""
    if message is None:
        return Transform.identity()
    q, t = message.rotation, message.translation
    R = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
    return Transform(R, 1000 * np.array([t.x, t.y, t.z]))


def _topics(reader, pattern: str) -> list:
    return [c for c in reader.connections if re.search(pattern, c.topic)]


def _last(reader, pattern: str) -> Any:
    """The last message of the topics that match, or None."""
    topics, message = _topics(reader, pattern), None
    for connection, _, raw in reader.messages(connections=topics) if topics else ():
        message = reader.deserialize(raw, connection.msgtype)
    return message


@contextmanager
def _reader(path: Path):
    reading, types = require("rosbags.highlevel", "realsense"), require("rosbags.typesys", "realsense")
    try:
        with reading.AnyReader([path], default_typestore=types.get_typestore(types.Stores.ROS1_NOETIC)) as reader:
            yield reader
    except BadInput:
        raise
    except Exception as error:  # rosbags meets damage with whatever its own code stumbles over
        why = next(iter(str(error).splitlines()), type(error).__name__)
        raise BadInput(f"{path}: not a whole RealSense recording ({why}); record it again") from error
