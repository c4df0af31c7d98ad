"""VMC: what a receiver hears over loopback, and Unity's axes."""

import socket

import numpy as np
from pythonosc.osc_bundle import OscBundle
from scipy.spatial.transform import Rotation

from gltf_files import performance
from mien.stream.face_frame import face_frames
from mien.stream.send import UdpSender, send_on_time
from mien.stream.vmc import encode_frame, unity_quaternion


def messages(data: bytes) -> list[tuple[str, list]]:
    return [(message.address, message.params) for message in OscBundle(data)]


def test_a_receiver_hears_weights_the_head_and_the_end_of_a_frame():
    frames = face_frames(performance(3))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        sender = UdpSender(receiver.getsockname(), encode_frame)
        send_on_time(frames, [sender], sleep=lambda _: None, clock=lambda: 0.0)
        sender.close()
        heard = [messages(receiver.recv(65536)) for _ in frames]
    assert heard[1][0] == ("/VMC/Ext/OK", [1])
    assert heard[1][-1] == ("/VMC/Ext/Blend/Apply", [])
    weights = {params[0]: params[1] for address, params in heard[1] if address == "/VMC/Ext/Blend/Val"}
    assert len(weights) == 52
    assert weights["jawOpen"] == np.float32(frames[1].weights["jawOpen"])
    [bone] = [params for address, params in heard[1] if address == "/VMC/Ext/Bone/Pos"]
    assert bone[0] == "Head"
    np.testing.assert_allclose(bone[4:], unity_quaternion(frames[1].rotation), atol=1e-6)


def test_names_for_perfect_sync():
    spelled = [params[0] for address, params in messages(encode_frame(face_frames(performance(1))[0], capitals=True))
               if address == "/VMC/Ext/Blend/Val"]  # fmt: skip
    assert "JawOpen" in spelled


def test_unity_axes_by_hand():
    """A head that turns to its own left looks along +x of ours and along -x of Unity's, whose +x is its right."""
    left = Rotation.from_euler("Y", 90, degrees=True)
    np.testing.assert_allclose(left.apply([0, 0, 1]), [1, 0, 0], atol=1e-12)
    in_unity = Rotation.from_quat(unity_quaternion(left.as_matrix()))
    np.testing.assert_allclose(in_unity.apply([0, 0, 1]), [-1, 0, 0], atol=1e-12)
    nod = Rotation.from_euler("X", 30, degrees=True)
    np.testing.assert_allclose(unity_quaternion(nod.as_matrix()), nod.as_quat(), atol=1e-12)
