"""Deformation transfer."""

import numpy as np
import pytest

from mien.mesh import Mesh, submesh
from mien.rig import Rig
from mien.rig.transfer import DeformationTransfer, nearest_faces, transfer_deltas, transfer_rig
from mien.transforms import rotation_from_vector


def grid(n=12, size=60.0, height=8.0):
    """A gently curved sheet of n x n vertices; its shape does not depend on n."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    z = height * np.exp(-2 * (x**2 + y**2))
    v = np.stack([x.ravel() * size, y.ravel() * size, z.ravel()], 1)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return Mesh(v, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def ball(centre, radius=12.0, n=8):
    """A closed octahedron-like sphere by latitude and longitude."""
    theta, phi = np.meshgrid(np.linspace(0.3, np.pi - 0.3, n), np.linspace(0, 2 * np.pi, 2 * n, endpoint=False))
    v = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    i = np.arange(2 * n * n).reshape(2 * n, n)
    j = np.roll(i, -1, axis=0)
    a, b, c, d = i[:, :-1].ravel(), i[:, 1:].ravel(), j[:, 1:].ravel(), j[:, :-1].ravel()
    return Mesh(np.asarray(centre) + radius * v, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def join(*meshes):
    starts = np.cumsum([0, *[len(m.vertices) for m in meshes]])
    faces = [m.faces + s for m, s in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


def bumps(mesh, k=3, seed=0):
    """Smooth displacements that vanish towards the sheet's rim."""
    rng = np.random.default_rng(seed)
    x = mesh.vertices
    out = []
    for centre in rng.uniform(-20, 20, (k, 2)):
        near = np.maximum(1 - ((x[:, :2] - centre) ** 2).sum(1) / 30**2, 0) ** 2
        out.append(near[:, None] * rng.normal(0, 4, 3))
    return np.stack(out)


def test_exact_where_source_and_target_are_the_same():
    mesh = join(grid(), ball([0, 0, -40.0]))
    rng = np.random.default_rng(1)
    deltas = rng.normal(0, 1, (4, len(mesh.vertices), 3))
    np.testing.assert_allclose(transfer_deltas(mesh, deltas, mesh), deltas, atol=1e-8)


def test_a_larger_copy_elsewhere_moves_likewise():
    source = grid()
    deltas = bumps(source)
    target = source.with_vertices(1.7 * source.vertices + [5.0, 0.0, 2.0])
    np.testing.assert_allclose(transfer_deltas(source, deltas, target), 1.7 * deltas, atol=1e-8)


def test_an_affine_map_of_the_source_is_the_same_affine_map_of_the_target():
    source, target = grid(), grid(height=0.0, size=45.0)
    A = np.eye(3) + np.random.default_rng(2).normal(0, 0.1, (3, 3))
    moved = DeformationTransfer(source, target).displacements(source.vertices @ A.T)
    # A triangle's own normal is what the third direction is made of; a flat target sees the in-plane part of S.
    inside = target.vertices + moved
    edges = inside[target.faces[:, 1]] - inside[target.faces[:, 0]]
    rest = target.vertices[target.faces[:, 1]] - target.vertices[target.faces[:, 0]]
    relative = np.linalg.norm(edges - rest @ A.T, axis=1) / np.linalg.norm(rest, axis=1)
    assert relative.mean() < 0.03


def test_a_rigid_part_stays_rigid_and_turns_about_its_own_middle():
    source = join(grid(), ball([0, 0, -40.0]))
    target = join(grid(height=3.0, size=70.0), ball([4.0, 3.0, -50.0], radius=14.0))
    R = rotation_from_vector(np.array([0.3, 0.2, 0.0]))
    eye = slice(144, None)
    delta = np.zeros((1, len(source.vertices), 3))
    delta[0, eye] = (source.vertices[eye] - [0, 0, -40.0]) @ R.T + [0, 0, -40.0] - source.vertices[eye]
    moved = target.vertices + transfer_deltas(source, delta, target)[0]
    expected = (target.vertices[eye] - [4.0, 3.0, -50.0]) @ R.T + [4.0, 3.0, -50.0]
    np.testing.assert_allclose(moved[eye], expected, atol=1e-6)
    np.testing.assert_array_equal(moved[:144], target.vertices[:144])


def test_another_topology_follows_through_the_nearest_triangles():
    source, target = grid(25), grid(14)
    found = transfer_deltas(source, bumps(source), target, nearest_faces(source, target))
    expected = bumps(target)
    assert np.abs(found - expected).max() < 0.12 * np.abs(expected).max()


def test_nearest_faces_prefers_the_side_that_faces_the_same_way():
    sheet = grid()
    back = Mesh(sheet.vertices - [0, 0, 0.2], sheet.faces[:, ::-1])
    both = join(sheet, back)
    lifted = sheet.with_vertices(sheet.vertices - [0, 0, 0.15])
    assert (nearest_faces(both, lifted) < len(sheet.faces)).all()


def test_transfer_rig_keeps_names_and_takes_the_target_as_neutral():
    source = grid()
    rig = Rig(source, bumps(source), ("a", "b", "c"))
    target = source.with_vertices(1.2 * source.vertices)
    out = transfer_rig(rig, target)
    assert out.names == rig.names
    np.testing.assert_allclose(out.mesh(np.array([0.5, 0, 0])).vertices, target.vertices + 0.6 * rig.deltas[0])


def test_missing_correspondence_is_refused():
    source = grid()
    part, _ = submesh(source, np.arange(10))
    with pytest.raises(ValueError, match="correspondence: needed"):
        DeformationTransfer(source, part)
