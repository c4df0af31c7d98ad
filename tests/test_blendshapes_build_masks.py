"""Masks, and textures that blend with the shapes."""

import numpy as np
import pytest

from mien.blendshapes.build.masks import (
    TexturedRig,
    mask_textures,
    masked,
    region_masks,
    regions_of,
    texture_weights,
)
from mien.faces import load_face
from mien.mesh import mass
from mien.rig import Rig


@pytest.fixture(scope="module")
def masks():
    return region_masks(load_face())


def test_masks_add_up_to_one_on_vertices_and_texels(masks):
    np.testing.assert_allclose(sum(masks.values()), 1)
    drawn = mask_textures(load_face().rig.neutral, masks, 64)
    np.testing.assert_allclose(sum(drawn.values()), 1, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "shape", "regions"),
    [
        ("eyes_closed", "jawOpen", ("eyes",)),
        ("kiss", "jawOpen", ("lower",)),
        ("brows_up", "jawOpen", ("upper", "eyes")),
        ("surprise", "browInnerUp", ("upper",)),
        ("happy", "mouthSmileLeft", ("lower",)),
        ("scan_07", "jawOpen", ("lower",)),
    ],
)
def test_a_name_says_where_an_expression_is_and_else_its_motion(name, shape, regions, masks):
    rig = load_face().rig
    delta = rig.deltas[rig.index(shape)]
    found = regions_of(name, delta, masks, mass(rig.neutral.vertices, rig.neutral.faces))
    assert set(regions) <= set(found)
    assert "lower" in regions or "lower" not in found


def test_a_blink_in_a_smile_leaves_the_mouth_alone(masks):
    rig = load_face().rig
    everywhere = rig.deltas[rig.index("eyeBlinkLeft")] + 0.5
    kept = masked(everywhere, ("eyes",), masks)
    mouth = rig.neutral.vertices[:, 1] < -40
    mouth[np.concatenate([load_face().parts[p] for p in ("left_eye", "right_eye")])] = False
    assert np.abs(kept[mouth]).max() == 0
    np.testing.assert_allclose(kept[masks["eyes"] == 1], everywhere[masks["eyes"] == 1])


def textured() -> TexturedRig:
    mesh = load_face().rig.neutral
    base = np.full((4, 4, 3), 100, np.uint8)
    rig = Rig(mesh, np.zeros((2, *mesh.vertices.shape)), ("smile", "blink"), base)
    halves = {"upper": np.zeros((4, 4)), "eyes": np.zeros((4, 4)), "lower": np.zeros((4, 4))}
    halves["eyes"][:2], halves["lower"][2:] = 1, 1
    pictures = np.stack([np.full_like(base, 200), np.full_like(base, 50)])
    return TexturedRig(rig, pictures, ("smile", "blink"), (("lower",), ("eyes",)), halves, np.eye(2))


def test_textures_blend_in_step_each_in_its_region():
    mixed = textured().texture(np.array([0.5, 1.0]))
    assert (mixed[:2] == 50).all()
    assert (mixed[2:] == 150).all()
    assert (textured().texture(np.zeros(2)) == 100).all()


def test_texture_shares_follow_weights_through_the_mixes():
    mixes = np.array([[0.9, 0.9, 0.0], [0.0, 0.0, 1.0]])
    shares = texture_weights(np.array([[0.9, 0.9, 0.0], [0.45, 0.45, 0.5], [0.0, 0.0, 0.0]]), mixes)
    np.testing.assert_allclose(shares, [[1, 0], [0.5, 0.5], [0, 0]], atol=0.03)
