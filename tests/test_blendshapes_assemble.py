"""Built expressions to one rig."""

import numpy as np
import pytest

from blendshape_faces import LAYOUT, face_landmarks, face_map
from mien.blendshapes.assemble import completed, with_masks
from mien.blendshapes.build.artist_mesh import ArtistMesh
from mien.blendshapes.build.texture import TexelGrid
from mien.blendshapes.correspond.dense import SkinWarp
from mien.blendshapes.expression import BuiltShape, NeutralFace, RigConfig
from mien.faces import ARKIT_NAMES, load_face

CONFIG = RigConfig(texture=64)


@pytest.fixture(scope="module")
def parts():
    face = load_face()
    mesh, n = face.rig.neutral, len(face.rig.neutral.vertices)
    artist = ArtistMesh(mesh, np.zeros((n, 2)), np.ones(n, bool), np.zeros((n, 3)))
    base = np.full((64, 64, 3), 0.5)
    grid = TexelGrid(np.zeros((64, 64, 2)), np.ones((64, 64), bool), base)
    calm = NeutralFace(face_map(), face_landmarks(), artist, face.rig.deltas, grid, base)
    same = SkinWarp(np.zeros((*LAYOUT.shape, 2)), np.ones(LAYOUT.shape, bool))
    jaw = face.rig.deltas[face.rig.index("jawOpen")]

    def shape(name):
        return BuiltShape(name, 0.7 * jaw, base + 0.1, np.ones(n, bool), face_map(), same, 400, 0.2)

    return calm, [shape("jawOpen"), shape("gape")]


def test_shapes_are_masked_and_masks_can_be_left_out(parts):
    face = load_face()
    rig = with_masks(*parts, face, CONFIG).rig
    free = with_masks(*parts, face, RigConfig(texture=64, masks=False)).rig
    above = face.rig.neutral.vertices[:, 1] > 20
    assert np.abs(rig.deltas[0][above]).max() == 0
    np.testing.assert_allclose(free.deltas[0], parts[1][0].delta)
    assert rig.names == ("jawOpen", "gape")


def test_completed_rigs_speak_arkit_and_keep_other_names(parts):
    textured = with_masks(*parts, load_face(), CONFIG)
    whole = completed(textured, *parts, load_face(), CONFIG)
    assert whole.rig.names == (*ARKIT_NAMES, "gape")
    assert whole.mixes.shape == (2, 53)
    assert whole.mixes[0, whole.rig.index("jawOpen")] == 1
