"""What is sent of a performance."""

import numpy as np

from gltf_files import performance
from mien.io.livelink import live_link_rows
from mien.stream.face_frame import face_frames, sampled


def test_frames_are_the_rows_of_a_live_link_file():
    play = performance()
    frames = face_frames(play)
    np.testing.assert_allclose([frame.row for frame in frames], live_link_rows(play))
    assert frames[5].weights["jawOpen"] == play.weights[5, play.rig.index("jawOpen")]
    relative = frames[3].rotation @ frames[0].rotation.T
    R = play.T_world_face.rotation
    turned = R[3] @ R[0].T
    np.testing.assert_allclose(np.trace(relative), np.trace(turned), atol=1e-9)


def test_another_rate_takes_the_nearest_frames_and_loops():
    frames = face_frames(performance(60))
    half = list(sampled(frames, 30.0, loop=False))
    assert len(half) == 30
    np.testing.assert_array_equal(half[10].row, frames[20].row)
    assert (half[10].number, half[10].rate) == (10, 30)
    endless = sampled(frames, None, loop=True)
    many = [next(endless) for _ in range(130)]
    np.testing.assert_array_equal(many[125].row, frames[5].row)
    assert many[125].number == 125
