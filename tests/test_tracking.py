"""The tracker from frame to frame, whole takes, and what is said when something is wrong with them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import tracking_stage as stage
from mien.depth import RGBDFrame
from mien.errors import BadInput
from mien.io.gltf import read_performance, write_performance
from mien.landmarks.stream import with_landmarks
from mien.mesh import vertex_normals
from mien.rig import Rig
from mien.tracking.pipeline import T_WORLD_CAMERA, TrackTakeConfig, track_frames, track_take
from mien.tracking.rigid import damp_pose
from mien.tracking.terms.fit_config import BlendshapeFitConfig
from mien.tracking.tracker import step
from mien.tracking.tracker_context import TrackConfig, initial_state, tracker_context

FRAMES = 30


@cache
def take():
    rig = stage.person()
    return stage.acted(rig, stage.talk(rig, FRAMES), stage.sway(FRAMES), noise=0.5)


@cache
def tracked():
    made, landmarker = take()
    return track_take(made, stage.person(), stage.landmarks(), landmarker)


def errors(results, weights, poses, field="vertices"):
    """Mean distance of the front from the truth in camera space, mm, frame by frame."""
    m = stage.model()
    out = []
    for r, w, T in zip(results, weights, poses, strict=True):
        truth = T.apply(m.blend(w).astype(float))
        out.append(m.share @ np.linalg.norm(r.T_camera_face.apply(getattr(r, field).astype(float)) - truth, axis=1))
    return np.array(out)


@cache
def tools_for(config):
    return tracker_context(stage.model(), stage.CAMERA, config)


def run(frames, marks, config=TrackConfig(), late=False):
    context = tools_for(config)
    state, results = initial_state(context), []
    for frame, landmarks in zip(frames, marks, strict=True):
        state, result = step(context, frame, landmarks, state, late=late)
        results.append(result)
    return results


@cache
def inputs():
    made, landmarker = take()
    frames = list(made)
    return frames, [landmarker.detect(None, f.time) for f in frames]


def test_the_take_is_followed_well_below_the_sensor_s_noise():
    results = run(*inputs())
    assert all(r.tracked for r in results)
    weights, poses = stage.talk(stage.person(), FRAMES), stage.sway(FRAMES)
    assert errors(results, weights, poses)[3:].mean() < 0.4
    m = stage.model()
    shown = np.array([m.share @ np.linalg.norm(m.blend(w) - m.neutral, axis=1) for w in weights])
    moving = shown > np.quantile(shown, 0.7)
    assert errors(results, weights, poses)[moving].mean() < 0.35 * shown[moving].mean()


def test_a_still_head_does_not_tremble():
    rig, rest, T = stage.person(), np.zeros(52), stage.pose()
    frames = [stage.sensed(rig, rest, T, t / 30, 0.8, seed=t) for t in range(25)]
    marks = [stage.told(rig, rest, T, 0.1, seed=t) for t in range(25)]
    results = run(frames, marks)[8:]
    places = np.stack([r.T_camera_face.apply(r.vertices.astype(float)) for r in results])
    assert np.sqrt(((places - places.mean(0)) ** 2).sum(2).mean()) < 0.1


def test_small_motion_is_held_back_and_large_motion_let_through():
    m, before = stage.model(), stage.pose((0.1, 0.2, 0.0))
    points, centre = m.neutral.astype(float), m.centre
    nudged, gone = stage.pose((0.1, 0.2, 0.0), (0.2, 0, 0)), stage.pose((0.15, 0.1, 0.0), (5, 3, 0))
    half = damp_pose(points, centre, before, nudged, 0.2)
    np.testing.assert_allclose(half.translation - before.translation, [0.1, 0, 0], atol=1e-9)
    through = damp_pose(points, centre, before, gone, 0.2)
    np.testing.assert_allclose(through.apply(m.neutral), gone.apply(m.neutral), atol=0.06)
    for same in (damp_pose(points, centre, before, gone, 0.0), damp_pose(points, centre, gone, gone, 0.2)):
        np.testing.assert_allclose(same.apply(m.neutral), gone.apply(m.neutral), atol=1e-9)


def test_a_head_that_was_hidden_is_found_again_at_once():
    frames, marks = (list(x) for x in inputs())
    for t in range(15, 20):
        frames[t] = RGBDFrame(frames[t].color, np.full_like(frames[t].depth, 300.0), frames[t].time)
        marks[t] = None
    results = run(frames, marks)
    assert not any(r.tracked for r in results[15:20])
    assert all(r.tracked for r in results[20:])
    np.testing.assert_array_equal(results[17].weights, results[16].weights)
    weights, poses = stage.talk(stage.person(), FRAMES), stage.sway(FRAMES)
    assert errors(results, weights, poses)[23:].mean() < 0.5


def test_late_landmarks_cost_little():
    frames, marks = inputs()
    late = run(frames, [None, *marks[:-1]], late=True)
    assert not late[0].tracked
    weights, poses = stage.talk(stage.person(), FRAMES), stage.sway(FRAMES)
    lagging, punctual = errors(late, weights, poses)[5:].mean(), errors(run(frames, marks), weights, poses)[5:].mean()
    assert lagging < punctual + 0.15


def test_each_stage_can_be_left_out():
    frames, marks = (x[:12] for x in inputs())
    full = TrackConfig()
    plain = run(frames, marks, replace(full, adaptive=False, output=False, correctives=False, smooth=False))
    for r in plain:
        np.testing.assert_array_equal(r.vertices, r.blend)
    anchored = run(frames, marks, replace(full, output=False, correctives=False))
    assert max(r.to_anchors for r in anchored) < 1e-3
    assert max(r.to_anchors for r in run(frames, marks, replace(full, correctives=False))) > 1e-3


def odd_person():
    """The person, with a bulge in the cheek that no shape knows and that comes and goes."""
    rig = stage.person()
    spot = stage.landmarks().attachment.points(rig.neutral)[425]
    away = np.linalg.norm(rig.neutral.vertices - spot, axis=1)
    bulge = np.exp(-((away / 20.0) ** 2))[:, None] * np.array([3.0, 0.0, 5.0])
    return Rig(rig.neutral, np.concatenate([rig.deltas, bulge[None]]), (*rig.names, "bulge"))


@cache
def odd_take(frames=45):
    odd = odd_person()
    weights = np.zeros((frames, len(odd.names)))
    weights[5:, -1] = np.sin(np.arange(frames - 5) / 5) ** 2
    return odd, weights, stage.acted(odd, weights, stage.sway(frames), noise=0.3)


def test_correctives_learn_what_the_shapes_cannot_say():
    odd, weights, (made, landmarker) = odd_take()
    frames = list(made)
    marks = [landmarker.detect(None, f.time) for f in frames]
    config = TrackConfig()
    config = replace(config, pca=replace(config.pca, warm_up=10))
    learnt, without = run(frames, marks, config), run(frames, marks, replace(config, correctives=False))
    bulging = weights[:, -1] > 0.5
    bulging[:25] = False
    m, shape = stage.model(), odd.deltas[-1][stage.model().front]
    truth, there = weights[:, -1:, None] * shape, np.linalg.norm(shape, axis=1) > 1.5
    normals = vertex_normals(m.neutral.astype(float), m.faces)

    def miss(results):
        """Mean distance along the normal where the bulge is, mm."""
        moved = np.stack([r.vertices - m.neutral for r in results])
        return np.abs(((moved - truth) * normals).sum(2))[bulging][:, there].mean()

    assert sum(r.learnt for r in learnt) >= 5  # a sample enters in one frame and changes the space in the next
    assert miss(learnt) < 0.75 * miss(without)


def test_a_performance_shows_the_final_mesh_and_survives_its_file(tmp_path):
    _, _, (made, landmarker) = odd_take()
    once = TrackTakeConfig(track=TrackConfig(fit=BlendshapeFitConfig(in_use=0.0)))
    result = track_take(made, stage.person(), stage.landmarks(), landmarker, once)
    names = result.performance.rig.names
    assert names[52] == "corrective_01"
    write_performance(tmp_path / "p.glb", result.performance)
    back = read_performance(tmp_path / "p.glb")
    assert back.rig.names == names
    np.testing.assert_allclose(back.weights, result.performance.weights, atol=1e-5)
    m, seen = stage.model(), with_landmarks(made, landmarker)
    for t, r in enumerate(track_frames(m, made, seen)):
        mesh = result.performance.rig.mesh(result.performance.weights[t])
        whole = m.whole(r.weights, r.vertices)
        assert np.linalg.norm(mesh.vertices - whole, axis=1)[m.front].mean() < 0.15


def test_the_head_pose_is_in_the_take_s_world():
    performance, poses = tracked().performance, stage.sway(FRAMES)
    truth = T_WORLD_CAMERA @ poses[20]
    points = stage.model().neutral.astype(float)
    off = performance.T_world_face[20].apply(points) - truth.apply(points)
    assert np.linalg.norm(off, axis=1).mean() < 0.8
    assert performance.T_world_face[20].translation[2] < -500


def test_video_alone_is_tracked_by_its_landmarks():
    made, landmarker = take()
    blind = replace(made, has_depth=False, frames=lambda: (replace(f, depth=None) for f in made))
    result = track_take(blind, stage.person(), stage.landmarks(), landmarker)
    weights = stage.talk(stage.person(), FRAMES)
    jaw = stage.person().index("jawOpen")
    assert np.corrcoef(result.performance.weights[:, jaw], weights[:, jaw])[0, 1] > 0.9
    assert np.isnan(result.errors).all()


def test_no_face_in_the_first_thirty_frames():
    made, _ = take()
    nobody = stage.Told(dict.fromkeys(round(f.time, 4) for f in made))
    with pytest.raises(BadInput, match="no face in the first 30 frames"):
        track_take(replace(made, count=31), stage.person(), stage.landmarks(), nobody)
    short = replace(made, frames=lambda: iter(inputs()[0][:5]), count=5)
    with pytest.raises(BadInput, match="no face in any of its 5 frames"):
        track_take(short, stage.person(), stage.landmarks(), nobody)


def test_a_take_that_breaks_off_keeps_what_was_tracked():
    made, landmarker = take()

    def broken():
        yield from inputs()[0][:10]
        raise BadInput("depth/000010.png: cannot be read to its end")

    result = track_take(replace(made, frames=broken), stage.person(), stage.landmarks(), landmarker)
    assert len(result.performance) == 10
    assert result.stopped == "depth/000010.png: cannot be read to its end"


def test_a_wrong_depth_scale_is_told():
    made, landmarker = take()
    large = replace(made, frames=lambda: (replace(f, depth=f.depth * np.float32(8)) for f in made))
    with pytest.raises(BadInput, match="multiply depth_scale"):
        track_take(large, stage.person(), stage.landmarks(), landmarker)


def test_a_rig_without_the_shapes_is_refused():
    made, landmarker = take()
    other = replace(stage.person(), names=tuple(f"s{i}" for i in range(52)))
    with pytest.raises(BadInput, match="none of the ARKit shapes"):
        track_take(made, other, stage.landmarks(), landmarker)
