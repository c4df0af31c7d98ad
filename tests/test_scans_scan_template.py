"""The template of many scans: the bundled one, and any mesh."""

import numpy as np

from mien.faces import load_face
from mien.mesh import Mesh, loop_subdivide, submesh
from mien.register import Surface
from mien.scans.scan_template import FINE_REGIONS, make_template, manifold_part, own_template, transfer_topology
from small_scans import bundled_template, sheet


def test_a_template_knows_its_parts_at_every_density():
    face, template = load_face(), bundled_template()
    assert set(template.regions) == {"face", *FINE_REGIONS}
    assert set(template.parts) == set(face.parts) - {"skin"}
    skin = template.skin.vertices
    np.testing.assert_allclose(template.whole(skin)[template.members], skin, atol=0.2)
    up = np.array([0.0, 3.0, 0.0])
    shifted = template.whole(skin + up)
    np.testing.assert_allclose(shifted, face.rig.neutral.vertices + up, atol=0.3)
    held = template.attachment_of(skin, skin[template.shown][::50] + 0.1)
    assert template.shown[template.skin.faces[held.faces]].all()
    lids = np.concatenate(list(face.contours.values()))
    assert template.fine_weight[np.isin(template.members, lids)].max() < 0.01


def test_the_manifold_part_of_a_mesh_has_no_forks_and_is_in_one_piece():
    mesh = sheet(9)
    fin = np.array([[0, 1, 81]])
    far = np.array([[82, 83, 84]])
    touching = np.array([[40, 85, 86]])
    vertices = np.concatenate([mesh.vertices, mesh.vertices[[0, 70, 71, 72, 60, 61]] + np.array([0, 0, 9.0])])
    found = manifold_part(Mesh(vertices, np.concatenate([mesh.faces, fin, far, touching])))
    assert 0 < len(mesh.faces) - len(found.faces) < 10
    same = manifold_part(mesh)
    np.testing.assert_array_equal(same.vertices, mesh.vertices)
    assert len(same.faces) == len(mesh.faces)


def test_any_mesh_can_be_the_template():
    bundled = bundled_template()
    skin = bundled.skin
    piece, _ = submesh(skin, np.flatnonzero((skin.vertices[skin.faces][..., 2] > 40).all(axis=1)))
    own = own_template(manifold_part(piece), bundled)
    assert own.parts == {}
    assert 0.9 < own.regions["face"].max() <= 1.0
    np.testing.assert_allclose(own.whole(own.skin.vertices), own.mesh.vertices, atol=0.2)
    out = np.array([0.0, 0.0, 5.0])
    moved = skin.vertices + out
    target = Surface(Mesh(moved, skin.faces))
    laid = transfer_topology(manifold_part(piece), skin, skin.with_vertices(moved), target)
    np.testing.assert_allclose(laid.vertices, manifold_part(piece).vertices + out, atol=0.05)


def test_lips_and_lids_have_their_sides_and_still_skin_stays_still_at_every_density():
    face, coarse = load_face(), bundled_template()
    mesh, _ = loop_subdivide(face.rig.neutral)
    fine = make_template(mesh, face)
    for template in (coarse, fine):
        assert set(template.sides) == {-3, -2, -1, 0, 1, 2, 3}
        lips = [template.skin.vertices[template.sides == value, 1].mean() for value in (1, -1)]
        assert lips[0] > lips[1] + 2.0
    old = fine.members < len(face.rig.neutral.vertices)
    alike = fine.sides[old] == coarse.sides
    assert alike.mean() > 0.98
    forehead = fine.regions["forehead_left"] > 0.9
    mouth = fine.regions["mouth"] > 0.9
    assert np.median(fine.mobility[mouth]) > 3 * np.median(fine.mobility[forehead])
