import numpy as np

from hilly_meshes import MESH, bent, hills
from mien.mesh import Attachment, Mesh, closest_point, vertex_normals
from mien.register import (
    Anchors,
    NonrigidConfig,
    Rejection,
    register_surface,
)
from mien.register.coarse import CoarseTemplate
from mien.transforms import Transform, rotation_from_vector


def test_a_template_meets_a_surface_of_other_triangles():
    target = hills(61, shift=0.007, triangles="other")
    target = target.with_vertices(bent(target.vertices))
    inner = hills(25, size=80.0)
    inner = inner.with_vertices(MESH.vertices * 0.8)
    inner = inner.with_vertices(closest_point(hills(61), inner.vertices).points)
    found = register_surface(inner, target)
    off = found.vertices - bent(inner.vertices)
    assert found.distances[found.accepted].mean() < 0.05
    assert found.accepted.mean() > 0.9
    normals = vertex_normals(found.vertices, inner.faces)
    across = np.abs(np.einsum("nd,nd->n", off, normals))[found.accepted]
    assert across.mean() < 0.1 * np.linalg.norm(bent(inner.vertices) - inner.vertices, axis=1).mean()
    assert np.linalg.norm(off, axis=1).mean() < np.linalg.norm(bent(inner.vertices) - inner.vertices, axis=1).mean()


def test_markers_are_met_and_carry_the_rest():
    """Markers on a smooth deformation bring most of it along, tangential part included (eq. 7, first two terms)."""
    truth = bent(MESH.vertices)
    rng = np.random.default_rng(3)
    faces = rng.choice(len(MESH.faces), 40, replace=False)
    at = Attachment(faces, np.full((40, 3), 1 / 3))
    anchors = Anchors(at, at.points(MESH.with_vertices(truth)), np.ones(40))
    found = register_surface(MESH, MESH.with_vertices(truth), anchors, NonrigidConfig(coarse=()))
    np.testing.assert_allclose(at.points(MESH.with_vertices(found.vertices)), anchors.points, atol=0.05)
    inner = np.abs(MESH.vertices[:, :2]).max(axis=1) < 40
    before = np.linalg.norm(MESH.vertices - truth, axis=1)[inner].mean()
    assert np.linalg.norm(found.vertices - truth, axis=1)[inner].mean() < 0.15 * before
    assert set(found.costs) == {"laplacian", "membrane", "markers", "closest"}


def test_registration_moves_with_its_input():
    T = Transform(rotation_from_vector(np.array([0.5, 1.0, -0.4])), np.array([10.0, -20, 30]))
    target = MESH.with_vertices(bent(MESH.vertices))
    plain = register_surface(MESH, target, config=NonrigidConfig(coarse=(0.01,)))
    turned = register_surface(
        MESH.with_vertices(T.apply(MESH.vertices)),
        target.with_vertices(T.apply(target.vertices)),
        config=NonrigidConfig(coarse=(0.01,)),
    )
    np.testing.assert_allclose(turned.vertices, T.apply(plain.vertices), atol=0.02)


def test_trust_zero_is_not_pulled():
    target = MESH.with_vertices(MESH.vertices + np.array([0, 0, 3.0]))
    trust = (MESH.vertices[:, 0] > 0).astype(float)
    found = register_surface(MESH, target, config=NonrigidConfig(plane=0.0), trust=trust * 0)
    np.testing.assert_allclose(found.vertices, MESH.vertices, atol=1e-6)
    free = Rejection(boundary=False, max_distance=5.0)
    half = register_surface(MESH, target, config=NonrigidConfig(coarse=(), rejection=free), trust=trust)
    assert half.distances[MESH.vertices[:, 0] > 0].max() < 0.3


def folded(n=61):
    """A strip bent over like a closed mouth: two sheets 0.2 mm apart, joined by a rim at the back; and each's side."""
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(0, 1, n), indexing="ij")
    side = np.tanh(u / 0.05)
    flat = np.stack([50 * np.abs(u), 60 * v, 0.1 * side], -1).reshape(-1, 3)
    return Mesh(flat, hills(n).faces), side.reshape(-1)


def test_sheets_that_touch_part_again():
    """Sheets open by up to 10 mm each: a coarse stand-in that looked for the closest point would tear them."""
    mesh, side = folded()
    coarse = CoarseTemplate(mesh, 500)
    opened = mesh.vertices + np.stack([np.zeros(len(side)), np.zeros(len(side)), side * mesh.vertices[:, 0] / 5], 1)
    found = coarse.up(coarse.down(opened))
    away = mesh.vertices[:, 0] > 5
    assert np.linalg.norm(found - opened, axis=1)[away].max() < 1.0
    assert (np.sign(found[away, 2]) == np.sign(side[away])).all()
    at = Attachment(np.arange(len(mesh.faces)), np.full((len(mesh.faces), 3), 1 / 3))
    there = coarse.attachment(at).points(coarse.mesh.with_vertices(coarse.down(opened)))
    sides = at.points(mesh.with_vertices(opened))[:, 2]
    assert (np.sign(there[:, 2]) == np.sign(sides))[np.abs(sides) > 1].all()
