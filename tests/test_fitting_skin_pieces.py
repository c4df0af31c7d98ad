"""Eyes, teeth and tongue of a scan are not skin."""

import numpy as np

from mien.faces import load_face
from mien.fitting.skin_pieces import skin_pieces
from mien.fitting.template_parts import TemplateParts
from mien.mesh import Mesh, submesh
from small_scans import sheet


def joined(*meshes: Mesh) -> Mesh:
    """Meshes beside each other in one."""
    start = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + first for mesh, first in zip(meshes, start, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def lid_and_eye() -> tuple[Mesh, Mesh]:
    """A sheet with a square hole, 34 mm wide, and a sheet that fills it, 1 mm behind."""
    whole = sheet(n=61)
    middle = np.abs(whole.vertices[whole.faces].mean(axis=1)[:, :2]).max(axis=1)
    eye = submesh(whole, middle < 16)[0]
    return submesh(whole, middle > 18)[0], eye.with_vertices(eye.vertices - np.array([0.0, 0.0, 1.0]))


def test_an_eye_between_the_lids_is_left_out_and_a_loose_patch_of_skin_stays():
    lid, eye = lid_and_eye()
    head = joined(lid, eye)
    x = lid.vertices[lid.faces].mean(axis=1)[:, 0]
    parted = [submesh(lid, x < 30)[0], submesh(lid, x > 32)[0]]
    found = skin_pieces(joined(*parted, eye), head, np.arange(len(lid.faces)))
    np.testing.assert_array_equal(found.vertices, joined(*parted).vertices)
    np.testing.assert_array_equal(found.faces, joined(*parted).faces)


def test_a_scan_of_one_piece_stays_as_it_is():
    lid, eye = lid_and_eye()
    head = joined(lid, eye)
    assert skin_pieces(eye, head, np.arange(len(lid.faces))) is eye


def test_the_bundled_faces_eyes_and_teeth_are_not_its_skin():
    face = load_face()
    head = face.rig.neutral
    skin = submesh(head, face.skin_faces)[0]
    found = skin_pieces(head, head, TemplateParts(face).in_the_open)
    assert len(found.faces) == len(skin.faces)
