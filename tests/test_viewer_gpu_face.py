import numpy as np

from mien.faces import load_face
from mien.mesh import loop_subdivide, vertex_normals
from mien.viewer.gpu_face import WIDTH, materials, neighbours, quantised, refined, rows_of, skies, texels


def test_neighbours_give_the_area_weighted_normals():
    mesh = load_face().rig.neutral
    spans, entries = neighbours(mesh.faces, len(mesh.vertices))
    vertex = 100
    around = entries[spans[vertex, 0] : spans[vertex].sum()]
    b, c = (mesh.vertices[around[:, i]] - mesh.vertices[vertex] for i in range(2))
    normal = np.cross(b, c).sum(axis=0)
    expected = vertex_normals(mesh.vertices, mesh.faces)[vertex]
    np.testing.assert_allclose(normal / np.linalg.norm(normal), expected, atol=1e-12)


def test_rows_give_the_matrix_back():
    mesh = load_face().rig.neutral
    fine = refined(mesh)
    assert fine.rounds == 1
    expected = loop_subdivide(mesh)[0].vertices
    spans, entries = rows_of(fine.matrix)
    row = len(expected) - 1
    mine = entries[spans[row, 0] : spans[row].sum()]
    np.testing.assert_allclose(mine[:, 1] @ mesh.vertices[mine[:, 0].astype(int)], expected[row], atol=1e-9)


def test_displacements_are_kept_to_a_thousandth_of_a_millimetre():
    deltas = load_face().rig.deltas
    stored, steps = quantised(deltas)
    back = stored[:, : deltas.shape[1]] * steps[:, None, None]
    assert np.abs(back - deltas).max() < 1e-3
    assert stored.shape[1] % WIDTH == 0
    assert quantised(np.zeros((2, 5, 3)))[1].tolist() == [0.0, 0.0]


def test_texels_fill_whole_rows():
    assert texels(np.ones((WIDTH + 1, 3)), 4).shape == (2 * WIDTH, 4)
    assert texels(np.ones((0, 2)), 2).shape == (WIDTH, 2)


def test_eyes_and_teeth_are_materials_of_their_own():
    face = load_face()
    found = materials(face.rig.neutral)
    assert found[face.parts["left_eye"], 0].all()
    assert found[face.parts["upper_teeth"], 1].all()
    assert not found[face.parts["skin"]].any()


def test_the_mouth_s_inside_is_dark_and_an_open_jaw_lets_light_in():
    face = load_face()
    closed, opened = skies(face.rig, refined(face.rig.neutral))
    inside, skin = (face.parts[name] for name in ("tongue", "skin"))
    assert closed[inside].max() < 0.01
    assert opened[inside].mean() > 0.03
    assert closed[skin].mean() > 0.6
