"""Guided capture, on a face that is known at every time."""

from functools import cache

import numpy as np
import pytest

from mien.blendshapes.scan.guide import POSES, GuideConfig, GuideState, apart, guide, guide_step, yaw_deg
from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.experiments.blendshapes_stage import EXPRESSIONS
from mien.faces import ARKIT_NAMES, load_face
from mien.landmarks.detector import Landmarks2D, bundled_landmarks
from mien.rgbd import RgbdTake
from mien.rgbd.live import Replay, live_frames
from mien.transforms import Transform, rotation_from_vector

RATE, CONFIG = 10.0, GuideConfig()
DEPTH = np.full((2, 2), 600.0, np.float32)
FACING = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 600.0]))
"""T_camera_face."""


@cache
def landmark_moves():
    """Landmarks of the face at rest, and what each shape adds."""
    rig, D = load_face().rig, bundled_landmarks().attachment.matrix(load_face().rig.neutral)
    return D @ rig.neutral.vertices, np.stack([D @ delta for delta in rig.deltas])


def landmarks(turn_deg=0.0, noise=0.0, seed=0, **weights):
    """Landmarks in camera space of a head turned to its left."""
    rest, moves = landmark_moves()
    points = rest + np.tensordot([weights.get(name, 0.0) for name in load_face().rig.names], moves, axes=1)
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


class Obedient:
    """A performer who does what was said a moment ago; `unquiet` changes the weights of a moment."""

    REACTION, TURN, RISE = 4, 3.0, 0.25
    """Frames until a word is heeded; degrees and share of an expression that a frame brings."""

    def __init__(self, unquiet=lambda weights, i: weights):
        self.heard, self.unquiet = ["neutral: look straight at the sensor"], unquiet
        self.yaw, self.weights, self.played = 0.0, dict.fromkeys(ARKIT_NAMES, 0.0), []

    def moment(self, i):
        """Landmarks of the next moment."""
        pose, _, word = self.heard[max(0, len(self.heard) - self.REACTION)].partition(":")
        goal = {name: EXPRESSIONS[pose].get(name, 0.0) for name in ARKIT_NAMES}
        self.weights = {n: w + np.clip(goal[n] - w, -self.RISE, self.RISE) for n, w in self.weights.items()}
        side = 25.0 * (("left" in word or "both" in word) - 1.0 * ("right" in word))
        self.yaw += np.clip(side - self.yaw, -self.TURN, self.TURN)
        self.played.append((self.yaw, self.unquiet(self.weights, i)))
        return landmarks(self.yaw, 0.8, i, **self.played[-1][1])

    def session(self, poses=POSES, most=500):
        """What was told after each frame."""
        state, told = GuideState(poses), []
        while state.poses and len(told) < most:
            i = len(told)
            state, one = guide_step(state, RGBDFrame(None, DEPTH, i / RATE), self.moment(i), CONFIG)
            self.heard.append(one.say)
            told.append(one)
        return told


def test_a_performer_who_obeys_is_captured_in_every_pose():
    performer = Obedient()
    told = performer.session()
    finished = {one.finished: one.frames for one in told if one.finished}
    assert tuple(finished) == POSES
    for pose, frames in finished.items():
        assert frames[-1].time - frames[0].time < CONFIG.longest_s
        shown = [performer.played[round(frame.time * RATE)] for frame in frames]
        yaws = np.array([yaw for yaw, _ in shown])
        assert yaws.min() < -14 < 14 < yaws.max()
        for name, goal in EXPRESSIONS[pose].items():
            assert min(weights[name] for _, weights in shown) > 0.7 * goal, (pose, name)


def test_a_performer_who_does_not_hold_still_is_told_so_and_captured_once_they_do():
    until = 60

    def talking(weights, i):
        return weights if i > until else {**weights, "jawOpen": 0.5 + 0.5 * np.sin(2.0 * i)}

    performer = Obedient(talking)
    told = performer.session(("neutral", "smile"))
    words = [one.say for one in told]
    assert set(words[1:until]) == {"neutral: hold still"}
    finished = {one.finished: one.frames for one in told if one.finished}
    assert tuple(finished) == ("neutral", "smile")
    assert finished["neutral"][0].time > until / RATE


def test_whoever_talks_while_turning_is_told_and_those_frames_do_not_count():
    def talking(weights, i):
        return {**weights, "jawOpen": 0.8, "mouthFunnel": 0.5} if 12 <= i < 20 else weights

    performer = Obedient(talking)
    told = performer.session(("neutral",))
    assert "neutral: hold the expression" in [one.say for one in told[12:20]]
    frames = next(one.frames for one in told if one.finished == "neutral")
    shown = [performer.played[round(frame.time * RATE)][1]["jawOpen"] for frame in frames]
    assert np.mean(np.array(shown) > 0.5) < 0.3
