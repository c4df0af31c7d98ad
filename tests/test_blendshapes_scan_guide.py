"""Guided capture, on a face that is known at every time."""

import numpy as np
import pytest

from mien.blendshapes.scan.guide import GuideConfig, GuideState, apart, guide, guide_step, yaw_deg
from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.faces import load_face
from mien.landmarks.detector import Landmarks2D, bundled_landmarks
from mien.rgbd import RgbdTake
from mien.rgbd.live import Replay, live_frames
from mien.transforms import Transform, rotation_from_vector

RATE, CONFIG = 10.0, GuideConfig()
DEPTH = np.full((2, 2), 600.0, np.float32)
FACING = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 600.0]))
"""T_camera_face."""


def landmarks(turn_deg=0.0, noise=0.0, seed=0, **weights):
    """Landmarks in camera space of a head turned to its left."""
    rig = load_face().rig
    mesh = rig.mesh(np.array([weights.get(name, 0.0) for name in rig.names]))
    points = bundled_landmarks().attachment.points(mesh)
    turned = points @ rotation_from_vector(np.array([0, np.radians(turn_deg), 0])).T
    return FACING.apply(turned) + np.random.default_rng(seed).normal(0, noise, points.shape)


def played(script, config=CONFIG, poses=("neutral", "smile")):
    """(seconds, what was said, what was finished) of landmarks in a row."""
    state, told = GuideState(poses), []
    for i, points in enumerate(script):
        state, one = guide_step(state, RGBDFrame(None, DEPTH, i / RATE), points, config)
        told.append(one)
        if not state.poses:
            break
    return state, told


def turning(**weights):
    """An expression held for a second, then turned to both sides."""
    angles = [*[0.0] * 10, *np.linspace(0, 24, 8), *np.linspace(24, -24, 16)]
    return [landmarks(a, 0.8, i, **weights) for i, a in enumerate(angles)]


SMILE = {"mouthSmileLeft": 1.0, "mouthSmileRight": 1.0, "cheekSquintLeft": 0.8, "cheekSquintRight": 0.8}


def test_poses_are_captured_one_after_the_other():
    state, told = played([*turning(), *turning(**SMILE)])
    assert state.poses == ()
    finished = [one for one in told if one.finished]
    assert [one.finished for one in finished] == ["neutral", "smile"]
    times = [[frame.time for frame in one.frames] for one in finished]
    assert times[0][-1] < 3.4 <= times[1][0] - CONFIG.still_s + 0.11
    assert min(map(len, times)) >= CONFIG.least
    assert "all is captured" in told[-1].say


def test_the_pose_before_is_no_new_one_and_a_moving_face_is_not_held():
    state, told = played([*turning(), *[landmarks(0.0, 0.8, 99)] * 20])
    assert state.poses == ("smile",)
    assert told[-1].say.startswith("smile: make it now")
    state, _ = played([*turning(), *[landmarks(0.0, 0.8, 99)] * 60])
    assert state.held is not None, "a pose that moves little is taken after a while"
    wild = [landmarks(jawOpen=0.5 + 0.5 * np.sin(2.0 * i)) for i in range(40)]
    state, told = played(wild)
    assert state.held is None
    assert {one.say for one in told} == {"neutral: hold still"}


def test_what_is_missing_is_said():
    _, told = played([landmarks()] * 30)
    assert told[-1].say == f"neutral: turn to your left, {len(told) - 5} frames"
    _, told = played([*turning()[:12], landmarks(jawOpen=1.0)])
    assert told[-1].say == "neutral: hold the expression"
    _, told = played([None])
    assert "no face is seen" in told[0].say


def test_a_pose_ends_in_time_with_what_it_has():
    state, told = played([landmarks()] * 160, poses=("neutral",))
    assert state.poses == ()
    assert len(told) == pytest.approx(CONFIG.longest_s * RATE, abs=3)


def test_angles_are_the_heads():
    assert yaw_deg(FACING.inverse().rotation) == pytest.approx(0, abs=1e-9)
    turn = Transform(rotation_from_vector(np.array([0, np.radians(20), 0])), np.zeros(3))
    assert yaw_deg((FACING @ turn).inverse().rotation) == pytest.approx(20)
    assert apart(landmarks(), landmarks()) == 0


class Told:
    """A landmarker that knows the pixels at each time."""

    def __init__(self, pixels):
        self.pixels = pixels

    def detect(self, image, time=None):
        return Landmarks2D(self.pixels[round(time * RATE)], np.zeros(478), {})


def test_a_recorded_clip_plays_by_the_clock():
    camera = Camera(400.0, 400.0, 159.5, 119.5, 320, 240)
    points = turning()
    depth = np.full((240, 320), 560.0, np.float32)
    color = np.zeros((240, 320, 3), np.uint8)
    take = RgbdTake("clip", camera, RATE, len(points), True,
                    lambda: iter([RGBDFrame(color, depth, i / RATE) for i in range(len(points))]))  # fmt: skip
    now = [0.0]
    source = Replay(take, clock=lambda: now[0], sleep=lambda s: now.__setitem__(0, now[0] + s))
    told = list(guide(live_frames(source), camera, Told([camera.project(p) for p in points]), ("neutral",)))
    assert now[0] == pytest.approx((len(told) - 1) / RATE, abs=0.11)
    assert "neutral" in told[0].say
