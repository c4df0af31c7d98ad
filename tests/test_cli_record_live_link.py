"""`mien track livelink`: packets over loopback become a performance on a rig."""

import socket
import threading
import time
from fractions import Fraction

import numpy as np
import pytest

from command import mien
from gltf_files import performance
from mien.cli import record_live_link
from mien.errors import BadInput
from mien.io.gltf import read_performance, write_rig
from mien.stream.face_frame import face_frames
from mien.stream.packet import LiveLinkPacket
from mien.stream.receive import LiveLinkReceiver
from mien.stream.send import live_link_bytes


def free_port() -> int:
    receiver = LiveLinkReceiver(("127.0.0.1", 0))
    receiver.close()
    return receiver.address[1]


def test_what_is_sent_is_recorded(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(record_live_link, "PATIENCE_S", 3.0)
    play, port = performance(12), free_port()
    write_rig(tmp_path / "rig.glb", play.rig)
    over = threading.Event()

    def phone() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not over.is_set():
                for frame in face_frames(play):
                    out.sendto(live_link_bytes("Ann")(frame), ("127.0.0.1", port))
                    time.sleep(0.001)

    sending = threading.Thread(target=phone)
    sending.start()
    try:
        mien("track", "livelink", rig=tmp_path / "rig.glb", output=tmp_path / "a.glb", listen=f":{port}", seconds=1.0)
    finally:
        over.set()
        sending.join()
    back = read_performance(tmp_path / "a.glb")
    assert len(back) == 12
    np.testing.assert_allclose(back.weights, play.weights, atol=1e-6)
    assert "recording Ann" in capsys.readouterr().err


def test_silence_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(record_live_link, "PATIENCE_S", 0.1)
    with pytest.raises(BadInput, match="no Live Link Face packet came"):
        mien("track", "livelink", output=tmp_path / "a.glb", listen=f":{free_port()}")
    with pytest.raises(BadInput, match="--rate does nothing for the Live Link Face app"):
        mien("track", "livelink", output=tmp_path / "a.glb", rate=30)


def interrupted():
    """A first packet, then Ctrl-C."""
    yield LiveLinkPacket("Ann", np.zeros(61, np.float32), 0, Fraction(60))
    raise KeyboardInterrupt


def test_what_was_recorded_before_ctrl_c_is_kept():
    assert len(record_live_link.collect(interrupted())) == 1
