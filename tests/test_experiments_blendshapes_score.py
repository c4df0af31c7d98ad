"""The score by true correspondence."""

import numpy as np
import pytest

from blendshape_faces import face_map
from blendshape_stage import actor
from mien.blendshapes.build.artist_mesh import on_map
from mien.blendshapes.cylinder_map import CylinderLayout, map_of_scan
from mien.experiments.blendshapes_score import drift, texels_a_mm, true_skin
from mien.experiments.blendshapes_stage import capture_weights
from mien.faces import load_face
from mien.mesh import Mesh, Scan


@pytest.fixture(scope="module")
def truth():
    neutral = map_of_scan(Scan(actor().neutral), CylinderLayout(1.0))
    faces = load_face().rig.neutral
    mesh = Mesh(actor().neutral.vertices, faces.faces, faces.uv, faces.uv_faces)
    artist = on_map(mesh, neutral)
    return true_skin(actor(), neutral, artist), artist


def test_the_truth_itself_has_no_error(truth):
    skin, artist = truth
    weights = capture_weights("jawOpen")
    goal = skin.points(weights)
    assert skin.neutral_mm < 0.1
    assert np.nanmax(drift(skin, goal, weights, artist.mesh, 1024)[skin.scored]) < 1.5
    true = skin.T_map_true.apply(actor().vertices(weights[None])[0])
    assert np.linalg.norm(goal - true, axis=1)[skin.scored].mean() < 0.3


def test_skin_that_slides_drifts_though_it_stays_on_the_surface(truth):
    skin, artist = truth
    weights = capture_weights("jawOpen")
    stuck = artist.mesh.vertices
    drifted = drift(skin, stuck, weights, artist.mesh, 1024)[skin.scored]
    assert np.quantile(drifted, 0.9) > 5
    assert face_map().known.any()


def test_texels_grow_with_the_texture(truth):
    mesh = truth[1].mesh
    assert np.isclose(texels_a_mm(mesh, 1024), 2 * texels_a_mm(mesh, 512))
