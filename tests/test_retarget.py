"""Performances on other rigs."""

from functools import cache

import igl
import numpy as np
import pytest

import tracking_stage as stage
from mien.cli.main import main
from mien.errors import BadInput
from mien.faces import load_face
from mien.io.gltf import read_performance, write_performance, write_rig
from mien.landmarks.face_correspondence import match_faces
from mien.landmarks.on_rig import attach_landmarks
from mien.mesh import ClosestPoint, Mesh, loop_subdivide, submesh
from mien.rig import Performance, Rig
from mien.rig.facs import FACS23
from mien.rig.retarget import lay_over, resolve_weights, retarget
from mien.rig.transfer import merged, transfer_deltas
from mien.transforms import Transform, rotation_from_vector


def sheet(n, size=60.0):
    """A domed sheet of n x n vertices, the same surface for every n."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n)))
    vertices = size * np.stack([x, y, 0.5 * np.exp(-2 * x**2 - 2 * y**2)], 1)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return Mesh(vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def bump(mesh, centre, direction, size=60.0):
    away = ((mesh.vertices[:, :2] / size - centre) ** 2).sum(1) / 0.5**2
    return np.maximum(1 - away, 0)[:, None] ** 2 * np.array(direction)


def rig_on(mesh, names=("jawOpen", "mouthSmileLeft"), size=60.0):
    shapes = [bump(mesh, (0, -0.3), (0, -6, 0), size), bump(mesh, (0.3, 0), (2, 2, 3), size)]
    return Rig(mesh, np.stack(shapes[: len(names)]), names)


def performed(rig, weights):
    t = len(weights)
    turn = rotation_from_vector(np.linspace(0, 0.3, t)[:, None] * [0, 1, 0])
    return Performance(rig, weights, Transform(turn, np.ones((t, 3))), 30.0, np.ones(t, bool))


def test_weights_go_by_name_and_the_pose_goes_along():
    take = performed(rig_on(sheet(12)), np.random.default_rng(0).random((5, 2)))
    target = rig_on(sheet(9), ("mouthSmileLeft", "jawOpen"))
    out = retarget(take, target)
    np.testing.assert_array_equal(out.performance.weights, take.weights[:, ::-1])
    np.testing.assert_array_equal(out.performance.T_world_face.rotation, take.T_world_face.rotation)
    assert (out.moved, out.dropped, out.correctives) == (("jawOpen", "mouthSmileLeft"), (), 0)


def test_what_the_target_lacks_is_named_if_it_is_used():
    take = performed(rig_on(sheet(12)), np.array([[0.5, 0.2], [0.1, 0.0]]))
    assert retarget(take, rig_on(sheet(9), ("jawOpen",))).dropped == ("mouthSmileLeft",)
    still = performed(take.rig, take.weights * [1, 0])
    assert retarget(still, rig_on(sheet(9), ("jawOpen",))).dropped == ()


def test_rigs_without_a_common_shape_are_refused():
    take = performed(rig_on(sheet(12)), np.zeros((1, 2)))
    with pytest.raises(BadInput, match="no shape in common"):
        retarget(take, rig_on(sheet(9), ("A", "B")))


def test_there_are_23_expressions_and_a_merged_one_is_the_sum():
    assert len(FACS23) == 23
    names = tuple(dict.fromkeys(name for parts in FACS23.values() for name in parts))
    deltas = np.random.default_rng(1).normal(size=(len(names), 16, 3))
    rig = Rig(sheet(4), deltas, names)
    whole = merged(rig)
    expected = deltas[names.index("browDownLeft")] + deltas[names.index("browDownRight")]
    np.testing.assert_array_equal(whole.deltas[whole.index("browDown")], expected)


def corrected(n):
    """A rig with a corrective on it, and its performance."""
    base = rig_on(sheet(n))
    extra = bump(base.neutral, (-0.2, 0.2), (0, 1, 4))
    rig = Rig(base.neutral, np.concatenate([base.deltas, extra[None]]), (*base.names, "corrective_01"))
    return performed(rig, np.array([[0.0, 0.0, 0.0], [0.5, 0.2, -1.0], [0.3, 0.9, 0.7]]))


def test_correctives_are_exact_on_the_same_surface():
    take = corrected(12)
    out = retarget(take, rig_on(sheet(12))).performance
    for a, b in zip(out.meshes(world=True), take.meshes(world=True), strict=True):
        np.testing.assert_allclose(a.vertices, b.vertices, atol=1e-8)


def test_correctives_show_on_another_topology_and_size():
    take, size = corrected(24), 90.0
    target = rig_on(sheet(15, size), size=size)
    out = retarget(take, target)
    assert out.correctives == 1
    found = out.performance.rig.deltas[-1]
    expected = 1.5 * bump(target.neutral, (-0.2, 0.2), (0, 1, 4), size)
    assert np.linalg.norm(found - expected, axis=1).max() < 0.2 * np.linalg.norm(expected, axis=1).max()
    assert retarget(take, target, correctives=False).performance.rig.names == target.names


def test_lay_over_undoes_scale_and_shift():
    source = sheet(20)
    moved = source.with_vertices(1.4 * source.vertices + [10, -5, 30])
    np.testing.assert_allclose(lay_over(source, moved).vertices, source.vertices, atol=0.05)


def test_weights_are_found_again_on_the_final_mesh():
    rig = rig_on(sheet(15))
    weights = np.array([[0.0, 0.0], [1.0, 0.3], [0.2, 0.9]])
    np.testing.assert_allclose(resolve_weights(rig, rig.vertices(weights)), weights, atol=1e-8)
    beyond = rig.vertices(np.array([[1.5, 0.0]]))
    np.testing.assert_allclose(resolve_weights(rig, beyond)[0, 0], 1.0)


SIZE = 1.15
"""How much larger than life the other person's head is."""


@cache
def acting():
    """Somebody whose cheek bulges as no blendshape can say, speaking and turning."""
    rig = stage.person(1)
    spot = stage.landmarks().attachment.points(rig.neutral)[425]
    near = np.exp(-((rig.neutral.vertices - spot) ** 2).sum(1) / 20**2)
    near = np.maximum(near - 0.01, 0)[:, None]
    full = Rig(rig.neutral, np.concatenate([rig.deltas, (near * [3, 0, 5])[None]]), (*rig.names, "corrective_01"))
    weights = np.zeros((3, len(full.names)))
    weights[1:, full.index("jawOpen")], weights[1:, -1] = 0.5, (1, -0.5)
    return performed(full, weights)


@cache
def remeshed():
    """Another person, larger, skin alone, subdivided, then decimated; landmarks; and what carries shapes over."""
    other = stage.person(7)
    skin = np.isin(other.neutral.faces, load_face().parts["skin"]).all(axis=1)
    mesh, old = submesh(other.neutral, np.flatnonzero(skin))
    fine, matrix = loop_subdivide(mesh)
    vertices, faces = (np.asarray(a) for a in igl.decimate(fine.vertices, fine.faces.astype(np.int64), 9000)[:2])
    near = ClosestPoint(fine).query(vertices)

    def carried(shape):
        return SIZE * np.einsum("pc,pcd->pd", near.barycentric, (matrix @ shape[old])[fine.faces[near.faces]])

    neutral = Mesh(SIZE * vertices, np.array(faces.tolist()))
    rig = Rig(neutral, np.stack([carried(delta) for delta in other.deltas]), other.names)
    points = SIZE * stage.landmarks().attachment.points(other.neutral)
    return rig, attach_landmarks(rig.neutral, points, np.ones(len(points), bool)), carried


def test_a_head_of_another_topology_shows_expression_corrective_and_pose():
    take, (target, landmarks, carried) = acting(), remeshed()
    out = retarget(take, target, match_faces(take.rig, target, (stage.landmarks(), landmarks)))
    assert len(target.neutral.faces) == 9000
    assert (out.dropped, out.correctives) == ((), 1)
    played = out.performance
    np.testing.assert_array_equal(played.T_world_face.rotation, take.T_world_face.rotation)
    np.testing.assert_array_equal(played.T_world_face.translation, take.T_world_face.translation)
    weights = np.array([played.weights[1, played.rig.index(name)] for name in target.names])
    jaw = target.vertices(weights) - target.neutral.vertices
    np.testing.assert_allclose(jaw, 0.5 * target.deltas[target.index("jawOpen")], atol=1e-9)
    # On the bundled topology the transfer is exact; brought over to the other mesh it is what is wanted here.
    bulge = transfer_deltas(take.rig.neutral, take.rig.deltas[-1:], stage.person(7).neutral)[0]
    wanted, found = carried(bulge), played.rig.deltas[-1]
    assert (wanted * found).sum() > 0.96 * np.linalg.norm(wanted) * np.linalg.norm(found)
    largest = np.linalg.norm(wanted, axis=1).max()
    assert np.linalg.norm(found - wanted, axis=1).max() < 0.3 * largest
    neck = target.neutral.vertices[:, 1] < target.neutral.vertices[:, 1].min() + 30
    assert np.linalg.norm(found[neck], axis=1).max() < 0.02 * largest


def test_misplaced_landmarks_do_not_lead_the_match_astray():
    take, (target, landmarks, _) = acting(), remeshed()
    sound = match_faces(take.rig, target, (stage.landmarks(), landmarks))
    points = landmarks.attachment.points(target.neutral)
    points[100:140] -= [0, 0, 180]
    fallen = attach_landmarks(target.neutral, points, np.ones(len(points), bool))
    found = match_faces(take.rig, target, (stage.landmarks(), fallen))
    middles = take.rig.neutral.vertices[take.rig.neutral.faces].mean(1)
    away = np.linalg.norm(middles[found] - middles[sound], axis=1)
    assert np.median(away) < 1.0
    assert np.percentile(away, 90) < 6.0


def test_from_the_shell_a_target_that_shows_no_face_is_still_driven_and_told_of(tmp_path, monkeypatch, capsys):
    def blind(*_):
        raise BadInput("the rig does not look like a face")

    write_performance(tmp_path / "perf.glb", acting())
    write_rig(tmp_path / "other.glb", remeshed()[0])
    monkeypatch.setattr("mien.cli.play.match_faces", blind)
    words = ["retarget", str(tmp_path / "perf.glb"), "--to", str(tmp_path / "other.glb"), "-o", str(tmp_path / "o.glb")]
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code in (0, None)
    told = capsys.readouterr().out
    assert "52 shapes and 1 correctives" in told
    assert "nearest points alone (the rig does not look like a face)" in told
    out = read_performance(tmp_path / "o.glb")
    assert len(out.rig.neutral.faces) == 9000
    np.testing.assert_allclose(out.T_world_face.translation, acting().T_world_face.translation, atol=1e-3)
