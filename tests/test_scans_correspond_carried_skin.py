"""Between the markers, scans lean along the skin towards where the markers' motion carries it."""

from dataclasses import replace

import numpy as np

from mien.faces import load_face
from mien.mesh import vertex_normals
from mien.scans.correspond.carried_skin import LeanConfig, along_skin, lean_on_markers
from small_scans import bundled_template
from test_scans_correspond_unmarked_skin import markers_on_the_face


def slipped() -> tuple[np.ndarray, np.ndarray]:
    """A smile at rest and played, and the latter with its skin slipped by a millimetre between the markers."""
    template, rig = bundled_template(), load_face().rig
    smile = sum(0.5 * rig.deltas[rig.index(f"mouthSmile{side}")][template.members] for side in ("Left", "Right"))
    true = template.skin.vertices + smile
    sideways = np.zeros_like(true)
    sideways[:, 0] = 1.0
    slip = along_skin(sideways, vertex_normals(true, template.skin.faces))
    slip[template.skin.faces[markers_on_the_face().faces].ravel()] = 0
    return np.stack([template.skin.vertices, true]), np.stack([template.skin.vertices, true + slip])


def test_skin_that_slipped_between_the_markers_comes_part_of_the_way_back():
    template, (true, given) = bundled_template(), slipped()
    face = (template.regions["face"] > 0.5) & template.shown
    leant = lean_on_markers(template, given, markers_on_the_face(), LeanConfig(share=0.4))
    np.testing.assert_array_equal(leant[0], given[0])
    before, after = (np.linalg.norm(x[1] - true[1], axis=1)[face].mean() for x in (given, leant))
    assert 0.55 * before < after < 0.75 * before
    moved, normals = (leant - given)[1], vertex_normals(given[1], template.skin.faces)
    np.testing.assert_allclose(np.einsum("nd,nd->n", moved, normals), 0, atol=1e-9)


def test_it_stays_where_nothing_is_known_or_asked():
    template, (_, given) = bundled_template(), slipped()
    places = markers_on_the_face()
    stranger = replace(template, person=None)
    np.testing.assert_array_equal(lean_on_markers(stranger, given, places), given)
    np.testing.assert_array_equal(lean_on_markers(template, given, places, LeanConfig(share=0.0)), given)


def test_along_a_surface_by_hand():
    found = along_skin(np.array([[1.0, 2.0, 3.0]]), np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_array_equal(found, [[1, 2, 0]])
