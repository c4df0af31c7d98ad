"""The steps of a marker solve, one by one."""

import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.faces import load_face
from mien.fitting.marker_identity import IdentityConfig, fit_identity, on_closest, person, surface_points
from mien.markers.attachment_file import read_attachment, write_attachment
from mien.markers.personalise_shapes import PersonaliseConfig, personalise_shapes, shape_corrections, spline
from mien.mesh import Attachment, ClosestPoint, submesh, vertex_normals
from mien.register import procrustes
from mien.register.align import align, starts
from mien.takes.depth_reliability import depth_metric
from mien.takes.frame_solve import SolveConfig, normal_equations, solve_frames, without_pose
from mien.takes.gaps import GapConfig, fill_gaps, gap_lengths
from mien.takes.marker_model import MarkerModel, marker_model
from mien.takes.stabilise import calm_frames, mean_cloud, stabilise
from mien.takes.world import turn_y_up
from mien.transforms import Transform, rotation_from_vector, vector_from_rotation

FREE = SolveConfig(sparsity=0.0, smoothness=0.0, ridge=1e-9, rounds=6, outlier=np.inf)


def motion(frames: int, seed: int, angle: float = 0.2, distance: float = 40.0) -> Transform:
    """A smooth head motion."""
    rng = np.random.default_rng(seed)
    phase, time = rng.uniform(0, 6, size=6), np.linspace(0, 5, frames)[:, None]
    waves = np.sin(time * rng.uniform(0.5, 1.5, size=6) + phase)
    return Transform(rotation_from_vector(angle * waves[:, :3]), distance * waves[:, 3:])


@pytest.fixture(scope="module")
def face():
    return load_face()


@pytest.fixture(scope="module")
def region(face):
    return np.flatnonzero((face.regions["face"] > 0.5)[face.rig.neutral.faces].all(axis=1))


@pytest.fixture(scope="module")
def held(face, region):
    """Sixty well-spread places on the face."""
    centres = face.rig.neutral.vertices[face.rig.neutral.faces[region]].mean(axis=1)
    chosen, distance = [0], np.full(len(region), np.inf)
    while len(chosen) < 60:
        distance = np.minimum(distance, np.linalg.norm(centres - centres[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return Attachment(region[chosen], np.full((60, 3), 1 / 3))


# gaps


def test_gap_lengths_by_hand():
    seen = np.array([[1, 0, 0, 1, 0, 1]], dtype=bool).T
    assert gap_lengths(seen).ravel().tolist() == [0, 2, 2, 0, 1, 0]


def test_short_gaps_follow_the_curve_middling_ones_the_other_markers_and_long_ones_stay():
    rng = np.random.default_rng(0)
    time = np.arange(300) / 60
    sources = np.stack([np.sin(2 * time), np.cos(3 * time), np.sin(time)], 1)
    truth = 10 + np.einsum("ts,smd->tmd", sources, rng.normal(size=(3, 9, 3)) * 4)
    holes = truth.copy()
    holes[50:54, 0], holes[100:120, 1], holes[150:290, 2] = np.nan, np.nan, np.nan
    filled = fill_gaps(holes, 60.0, GapConfig(rank=3, sweeps=60))
    np.testing.assert_allclose(filled[50:54, 0], truth[50:54, 0], atol=0.02)
    np.testing.assert_allclose(filled[100:120, 1], truth[100:120, 1], atol=0.3)
    assert np.isnan(filled[150:290, 2]).all()
    np.testing.assert_array_equal(filled[np.isfinite(holes)], holes[np.isfinite(holes)])


def test_a_frame_in_which_nothing_was_seen_stays_empty():
    X = np.random.default_rng(0).normal(size=(40, 8, 3))
    X[10] = np.nan
    assert np.isnan(fill_gaps(X, 60.0)[10]).all()


# head


def test_stabilise_takes_out_head_motion_and_trusts_still_markers():
    rng = np.random.default_rng(1)
    rest, T = rng.normal(size=(12, 3)) * 50, motion(200, 2)
    face = np.repeat(rest[None], 200, axis=0)
    face[:, 8:, 1] += 8 * np.abs(np.sin(np.linspace(0, 20, 200)))[:, None]
    X = T.apply(face)
    X[rng.random(X.shape[:2]) < 0.05] = np.nan
    done = stabilise(Markers(X, tuple("abcdefghijkl"), 60.0))
    still = done.markers.positions[:, :8]
    assert np.nanmax(np.nanstd(still, axis=0)) < 0.15
    assert done.weights[:8].min() > 3 * done.weights[8:].max()


def test_stabilise_needs_three_markers_somewhere():
    X = np.full((5, 8, 3), np.nan)
    X[:, :2] = 0.5
    with pytest.raises(BadInput, match="fewer than 3 markers"):
        stabilise(Markers(X, tuple("abcdefgh"), 30.0))


def test_the_calm_frame_is_the_one_dwelt_at_whatever_its_place():
    rng = np.random.default_rng(3)
    X = rng.normal(size=(1, 10, 3)) * 40 + 3 * rng.normal(size=(300, 1, 3)) * rng.normal(size=(1, 10, 3))
    X[200:240] = X[200] + 0.01 * rng.normal(size=(40, 10, 3))
    first = calm_frames(X)[0]
    assert 200 <= first < 240
    np.testing.assert_allclose(mean_cloud(X, first), X[200], atol=0.05)


def test_the_world_is_the_lab_turned_upright():
    for up in (np.array([np.pi / 2, 0, 0]), np.array([0, 0, -np.pi / 2]), np.array([np.pi, 0, 0]), np.zeros(3)):
        lean = rotation_from_vector(np.array([[0.1, 0.3, -0.1], [0.1, 0.4, 0.1]]))
        T = Transform(rotation_from_vector(up) @ lean, np.ones((2, 3)))
        world = turn_y_up(T)
        assert (world.rotation[:, 1, 1] > 0.9).all()
        turn = world.rotation @ np.swapaxes(T.rotation, 1, 2)
        np.testing.assert_allclose(turn, np.round(turn), atol=1e-12)


def test_depth_of_one_camera_is_told_from_depth_of_many():
    rng = np.random.default_rng(4)
    rest = rng.uniform(-50, 50, size=(16, 3)) * [1, 1, 0.3]
    moved = rest + rng.normal(size=(300, 16, 3)) * [2, 3, 1.5]
    real = motion(300, 5).apply(moved)
    flat = moved.copy()
    flat[..., 2] = 20 - 0.004 * (flat[..., 0] ** 2 + flat[..., 1] ** 2)
    assert depth_metric(real).known
    found = depth_metric(flat)
    assert not found.known
    assert np.linalg.eigvalsh(found.metric)[0] < 0.05


# alignment and identity


def test_starts_are_rotations_that_cover_both_sides_of_every_axis():
    R = np.stack(starts(np.random.default_rng(0).normal(size=(20, 3)) * [3, 2, 1], 12))
    assert R.shape == (72, 3, 3)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-9)


def test_a_persons_markers_are_found_from_any_pose(face, region, held):
    rng = np.random.default_rng(7)
    someone = person(face, 0.8 * rng.normal(size=len(face.identity.modes)))
    truth = surface_points(someone, held, 2.5)
    lab = Transform(rotation_from_vector(np.array([2.0, -1.0, 0.5])), np.array([300.0, -200, 900]))
    lifted = face.rig.neutral.vertices + 3 * vertex_normals(face.rig.neutral.vertices, face.rig.neutral.faces)
    surface = ClosestPoint(submesh(face.rig.neutral.with_vertices(lifted), region)[0])
    best = align(lab.apply(truth), surface)[0]
    turn = vector_from_rotation(best.T_face_head.rotation @ lab.rotation)
    assert np.degrees(np.linalg.norm(turn)) < 12
    fit = fit_identity(lab.apply(truth), face, region, best.T_face_head)
    mask = face.regions["face"] > 0.5
    mean = procrustes(face.rig.neutral.vertices[mask], someone.vertices[mask], scale=True).transform
    tree = ClosestPoint(someone)
    before = tree.query(mean.apply(face.rig.neutral.vertices[mask])).distances.mean()
    assert tree.query(fit.neutral.vertices[mask]).distances.mean() < 0.9 * before
    assert fit.residuals.mean() < 0.6
    assert on_closest(fit, lab.apply(truth), region).residuals.max() < 3


def test_known_places_pin_the_person_down(face, region, held):
    rng = np.random.default_rng(8)
    someone = person(face, 0.8 * rng.normal(size=len(face.identity.modes)))
    cloud = surface_points(someone, held, 3.0)
    firm = IdentityConfig(noise_mm=0.05, slide_mm=(0.05, 0.05), rounds=8)
    fit = fit_identity(cloud, face, region, Transform.identity(), held, config=firm)
    mask = face.regions["narrow"] > 0.5
    assert np.linalg.norm((fit.neutral.vertices - someone.vertices)[mask], axis=1).mean() < 0.6


# solve


@pytest.fixture(scope="module")
def model():
    rng = np.random.default_rng(9)
    return MarkerModel(rng.normal(size=(40, 3)) * 40, rng.normal(size=(6, 40, 3)) * 4)


@pytest.fixture(scope="module")
def acted(model):
    """Weights, head motion and the clean markers they make."""
    rng = np.random.default_rng(10)
    W = np.clip(rng.normal(0.1, 0.4, size=(50, 6)), 0, 1)
    T = motion(50, 11)
    return W, T, T.apply(model.points(W))


def test_normal_equations_and_elimination_agree_with_plain_least_squares(model):
    rng = np.random.default_rng(12)
    used, r = rng.random((4, 40)) < 0.8, rng.normal(size=(4, 40, 3))
    M = np.diag([1.0, 1.0, 0.2])
    A = model.jacobian()
    G, b = normal_equations(A, M, r, used)
    reduced, right, back = without_pose(G, b)
    for t in range(4):
        rows = (np.sqrt(M) @ A[used[t]]).reshape(-1, A.shape[2])
        plain = np.linalg.lstsq(rows, (r[t, used[t]] @ np.sqrt(M)).ravel(), rcond=None)[0]
        w = np.linalg.solve(reduced[t], right[t])
        np.testing.assert_allclose(w, plain[:6], atol=1e-6)
        np.testing.assert_allclose(back[t, :, 0] - back[t, :, 1:] @ w, plain[6:], atol=1e-3)


def test_jacobian_is_the_derivative_of_the_posed_points(model):
    A, h = model.jacobian(), 1e-6
    for column in range(A.shape[2]):
        x = np.zeros(A.shape[2])
        x[column] = h
        posed = Transform(rotation_from_vector(x[6:9]), x[9:]).apply(model.points(x[:6]))
        np.testing.assert_allclose((posed - model.rest) / h, A[..., column], atol=1e-3)


def test_clean_markers_give_weights_and_pose_back(model, acted):
    W, T, X = acted
    start = Transform(T.rotation @ rotation_from_vector(np.full((50, 3), 0.03)), T.translation + 2)
    solved = solve_frames(model, X, start, 60.0, config=FREE)
    np.testing.assert_allclose(solved.weights, W, atol=2e-3)
    np.testing.assert_allclose(solved.T_lab_face.rotation, T.rotation, atol=1e-3)
    assert np.nanmax(solved.residuals) < 0.05
    assert solved.converged


def test_the_lab_has_no_say(model, acted):
    _, T, X = acted
    lab = Transform(rotation_from_vector(np.array([0.3, 2.0, -1.0])), np.array([100.0, 5, -70]))
    many = Transform(np.broadcast_to(lab.rotation, (50, 3, 3)), np.broadcast_to(lab.translation, (50, 3)))
    here = solve_frames(model, X, T, 60.0)
    there = solve_frames(model, lab.apply(X.reshape(-1, 3)).reshape(X.shape), many @ T, 60.0)
    np.testing.assert_allclose(here.weights, there.weights, atol=1e-5)


def test_gaps_outliers_and_empty_frames_do_no_harm(model, acted):
    W, T, X = acted
    X = X.copy()
    X[5, :10], X[20] = np.nan, np.nan
    X[30, 3] += 60
    solved = solve_frames(model, X, T, 60.0, config=SolveConfig(sparsity=0.0, smoothness=0.0, ridge=1e-9, rounds=6))
    assert not solved.tracked[20]
    assert solved.tracked.sum() == 49
    np.testing.assert_array_equal(solved.weights[20], solved.weights[19])
    assert not solved.used[30, 3]
    np.testing.assert_allclose(solved.weights[[5, 30]], W[[5, 30]], atol=5e-3)


def test_smoothness_calms_and_sparsity_empties(model, acted):
    _, T, X = acted
    noisy = X + np.random.default_rng(0).normal(size=X.shape)
    free = solve_frames(model, noisy, T, 60.0, config=FREE).weights
    smooth = solve_frames(model, noisy, T, 60.0, config=SolveConfig(sparsity=0.0, smoothness=1e4, ridge=0.0)).weights
    sparse = solve_frames(model, noisy, T, 60.0, config=SolveConfig(sparsity=200.0, smoothness=0.0, ridge=0.0)).weights
    assert np.abs(np.diff(smooth, axis=0)).mean() < 0.2 * np.abs(np.diff(free, axis=0)).mean()
    assert (sparse > 1e-6).sum() < (free > 1e-6).sum()


# adaptation


def test_marker_model_stands_off_along_the_normal(face, held):
    on, off = (marker_model(face.rig, held, np.full(60, s)) for s in (0.0, 3.0))
    np.testing.assert_allclose(np.linalg.norm(off.rest - on.rest, axis=1), 3, atol=1e-9)
    moved = np.stack([held.matrix(face.rig.neutral) @ d for d in face.rig.deltas])
    np.testing.assert_allclose(on.shapes, moved, atol=1e-9)


def test_corrections_recover_a_performers_bent_shapes(model):
    rng = np.random.default_rng(13)
    W = np.clip(rng.normal(0.2, 0.4, size=(800, 6)), 0, 1)
    bent = MarkerModel(model.rest, model.shapes * (1 + 0.3 * rng.normal(size=(6, 40, 1))))
    targets = bent.points(W) + 0.05 * rng.normal(size=(800, 40, 3))
    used = rng.random((800, 40)) < 0.9
    neutral, shapes = shape_corrections(model, W, targets, used, 8.0)
    np.testing.assert_allclose(model.shapes + shapes, bent.shapes, atol=0.15)
    np.testing.assert_allclose(neutral, 0, atol=0.1)


def test_spread_interpolates_smoothly_and_stays_on_the_skin(face, held):
    skin = face.parts["skin"]
    S = spline(face.rig.neutral, held, skin)
    smooth = held.points(face.rig.neutral)[:, 1] / 50
    at_markers = held.matrix(face.rig.neutral) @ (S @ smooth)
    np.testing.assert_allclose(at_markers, smooth, atol=0.05)
    assert not S[face.parts["left_eye"]].any()
    back = np.argmin(face.rig.neutral.vertices[:, 2])
    assert np.abs(S[back]).max() < 0.05


def test_bent_rig_meets_the_corrections_and_leaves_still_shapes_still(face, held):
    field = np.tile(np.random.default_rng(14).normal(size=3), (60, 1))
    S = spline(face.rig.neutral, held, face.parts["skin"])
    corrections = 0.2 * np.stack([held.matrix(face.rig.neutral) @ d for d in face.rig.deltas])
    bent = personalise_shapes(face.rig, held, field, corrections, S, PersonaliseConfig())
    np.testing.assert_allclose(held.points(bent.neutral) - held.points(face.rig.neutral), field, atol=0.15)
    smile = face.rig.index("mouthSmileLeft")
    D = held.matrix(face.rig.neutral)
    wanted = 1.2 * (D @ face.rig.deltas[smile])
    assert np.abs(D @ bent.deltas[smile] - wanted).max() < 0.35 * np.abs(0.2 * wanted).max()
    look = face.rig.index("eyeLookUpLeft")
    ball = face.parts["left_eye"]
    np.testing.assert_array_equal(bent.deltas[look][ball], face.rig.deltas[look][ball])


# by hand


def test_placements_come_back_as_written(tmp_path, held):
    labels = tuple(f"m{i}" for i in range(60))
    write_attachment(tmp_path / "a.json", labels, held)
    back = read_attachment(tmp_path / "a.json", labels[::-1], 100_000)
    np.testing.assert_array_equal(back.faces, held.faces[::-1])
    np.testing.assert_allclose(back.barycentric, held.barycentric, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("not json", "not a JSON file"),
        ('{"b": {"face": 0, "barycentric": [1, 0, 0]}}', "no place given for a"),
        ('{"a": {"face": 99, "barycentric": [1, 0, 0]}}', r"triangle 99 is not among the rig's 0\.\.9"),
        ('{"a": {"face": 1, "barycentric": [1, 1, 0]}}', "add up to 1"),
        ('{"a": 5}', "expected"),
    ],
)
def test_bad_placements_are_refused(tmp_path, text, says):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(BadInput, match=says):
        read_attachment(tmp_path / "a.json", ("a",), 10)
