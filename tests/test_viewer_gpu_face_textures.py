"""Textures that change with the shapes, in the page: what its GPU draws against what the library draws."""

from dataclasses import replace

import numpy as np
import pytest

from browser import browser, page_at, seen_from
from mien.blendshapes.build.masks import TexturedRig, mask_textures, region_masks, texture_weights
from mien.faces import load_face
from mien.pictures import Renderer, frontal_camera
from mien.pictures.show import rig_look
from mien.viewer.gpu_face import textures_in_step
from mien.viewer.page_files import export_page
from mien.viewer.scene_file import SceneWriter, read_array, read_scene
from mien.viewer.studio_scene import Shown, pack_scene
from studio_things import nodding

SIZE, FRAME, TEXELS = 320, 12, 64


@pytest.fixture(scope="module")
def performance():
    """One whose weights make half of one capture and all of another."""
    played = nodding()
    base = np.full((TEXELS, TEXELS, 3), (190, 150, 130), np.uint8)
    weights = np.zeros_like(played.weights)
    weights[:, played.rig.index("mouthSmileLeft")] = 0.5
    weights[:, played.rig.index("browInnerUp")] = 1.0
    return replace(played, rig=replace(played.rig, texture=base), weights=weights)


@pytest.fixture(scope="module")
def textured(performance):
    rig, face = performance.rig, load_face()
    pictures = np.empty((3, TEXELS, TEXELS, 3), np.uint8)
    pictures[:] = np.array([(250, 40, 40), (40, 200, 60), (20, 20, 250)], np.uint8)[:, None, None]
    mixes = np.zeros((3, len(rig.names)))
    for row, name in enumerate(("mouthSmileLeft", "browInnerUp", "jawOpen")):
        mixes[row, rig.index(name)] = 1.0
    regions = (("lower",), ("upper", "eyes"), ("lower",))
    masks = mask_textures(rig.neutral, region_masks(face), TEXELS)
    return TexturedRig(rig, pictures, ("grin", "brows", "jaw"), regions, masks, mixes)


def test_the_page_draws_the_texture_that_the_library_draws(performance, textured, tmp_path):
    rig = performance.rig
    view = frontal_camera(rig.neutral, SIZE, yaw=0.3)
    export_page(tmp_path / "page", pack_scene([Shown("perf.glb", performance, textured=textured)]))
    with browser() as chromium:
        page = page_at(chromium, (tmp_path / "page" / "index.html").as_uri())
        page.wait_for_function("studio.current.face.textures.ready && studio.current.face.texture")
        drawn = seen_from(page, view, SIZE, FRAME)
    weights = performance.weights[FRAME]
    shares = texture_weights(weights[None], textured.mixes)[0]
    assert shares[2] == 0
    renderer = Renderer(rig.neutral, rig_look(rig.neutral), textured.texture(shares))
    expected = renderer.draw(*view, vertices=rig.vertices(weights)).astype(int)
    off = np.abs(drawn - expected).max(axis=2)
    assert off.mean() < 2
    assert (off <= 12).mean() > 0.97


def test_shapes_are_matched_by_name_and_unknown_ones_have_no_texture(textured):
    scene = SceneWriter()
    told = textures_in_step(textured, ("corrective_01", "jawOpen"), scene)
    _, body = read_scene(scene.file({}))
    np.testing.assert_array_equal(read_array(body, told["mixes"]), [[0, 0], [0, 0], [0, 1]])
    np.testing.assert_array_equal(read_array(body, told["regions"])[1], [1, 1, 0])
    assert len(told["captures"]) == 3
