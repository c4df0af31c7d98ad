"""`mien stream`: out over loopback, and what is refused."""

import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

from command import mien
from gltf_files import performance
from mien.cli.stream import tracked_frames
from mien.errors import BadInput
from mien.io.gltf import write_performance
from mien.io.livelink import live_link_rows, write_live_link
from mien.stream.packet import decode


@pytest.fixture
def phone():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(30)
        yield receiver


def test_a_file_to_both_receivers(tmp_path, phone, capsys):
    play = performance(6)
    write_performance(tmp_path / "a.glb", play)
    port = phone.getsockname()[1]
    mien("stream", tmp_path / "a.glb", livelink=f"127.0.0.1:{port}", vmc="127.0.0.1:9", fps=600)
    told = capsys.readouterr()
    assert "sending to VMC 127.0.0.1:9 and Live Link" in told.err
    first = decode(phone.recv(65536))
    assert first.subject == "mien"
    np.testing.assert_allclose(first.values, live_link_rows(play)[0], atol=1e-6)
    assert told.out.startswith("sent ")


def test_a_live_link_file(tmp_path, phone, capsys):
    write_live_link(tmp_path / "a.csv", performance(4))
    port = phone.getsockname()[1]
    mien("stream", tmp_path / "a.csv", livelink=f":{port}", subject="Ann", loop=True, seconds=0.1)
    assert decode(phone.recv(65536)).subject == "Ann"


def test_ctrl_c_ends_a_loop_cleanly(tmp_path, phone):
    write_live_link(tmp_path / "a.csv", performance(4))
    port = phone.getsockname()[1]
    line = [sys.executable, "-c", "import signal; signal.signal(2, signal.default_int_handler); "
            "from mien.cli.main import main; main()",
            "stream", str(tmp_path / "a.csv"), "--livelink", f":{port}", "--loop"]  # fmt: skip
    running = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    phone.recv(65536)
    time.sleep(0.1)
    os.kill(running.pid, signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert running.returncode == 0, err
    assert out.startswith("sent ")
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("words", "options", "told"),
    [
        (["a.glb"], {}, "name a receiver"),
        (["a.c3d"], {"vmc": ":1"}, "solve a.c3d -o perf.glb"),
        (["none.glb"], {"vmc": ":1"}, "no such file"),
        (["a.glb"], {"vmc": ":1", "device": "x"}, "does nothing without live"),
        (["a.glb"], {"vmc": ":1", "rig": "r.glb"}, "does nothing for what is not tracked"),
        (["livelink"], {"vmc": ":1", "loop": True}, "does nothing for what comes by itself"),
        (["a.glb"], {"vmc": "host:x"}, "is no port"),
    ],
)
def test_what_is_refused(words, options, told):
    with pytest.raises(BadInput, match=told):
        mien("stream", *words, **options)


def test_tracked_frames_leave_as_the_tracker_says():
    class Result:
        def __init__(self, tracked, pose, weights):
            self.tracked, self.T_camera_face, self.weights = tracked, pose, weights

    play = performance(3)
    results = [Result(t != 1, play.T_world_face[t], play.weights[t]) for t in range(3)]
    frames = list(tracked_frames(results, play.rig, 30.0))
    assert [frame.number for frame in frames] == [0, 2]
    assert frames[1].weights["jawOpen"] == pytest.approx(play.weights[2, play.rig.index("jawOpen")])
