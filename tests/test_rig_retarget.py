"""Performances on other rigs."""

import numpy as np
import pytest

from mien.errors import BadInput
from mien.rig import Rig
from mien.rig.retarget import lay_over, resolve_weights, retarget
from sheet_rigs import performed, sheet


def bump(mesh, centre, direction, size=60.0):
    away = ((mesh.vertices[:, :2] / size - centre) ** 2).sum(1) / 0.5**2
    return np.maximum(1 - away, 0)[:, None] ** 2 * np.array(direction)


def rig_on(mesh, names=("jawOpen", "mouthSmileLeft"), size=60.0):
    shapes = [bump(mesh, (0, -0.3), (0, -6, 0), size), bump(mesh, (0.3, 0), (2, 2, 3), size)]
    return Rig(mesh, np.stack(shapes[: len(names)]), names)


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
