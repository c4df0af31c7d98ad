import numpy as np
import pytest

import light_scene
from mien.errors import BadInput
from mien.light.normals import (
    GlossConfig,
    NormalMap,
    PointLamp,
    gradient_normals,
    photometric_normals,
    without_highlights,
)
from mien.light.patterns import paper_set
from mien.light.triangulate import pixel_rays

RIG = light_scene.rig()
LEFT = RIG.cameras[0]
R_VIEW_LAMPS = RIG.R_view_lamps(LEFT)
PATTERNS = paper_set(64, 64)
DEPTH, NORMALS = light_scene.ball_depth(LEFT)
SEEN = np.isfinite(DEPTH)


def angle(found, mask):
    return np.degrees(np.arccos(np.clip((found * NORMALS).sum(-1)[mask], -1, 1)))


def lamp_pictures(albedo=0.5):
    images = np.zeros((12, *DEPTH.shape))
    world = NORMALS @ np.array(RIG.R_rig_lamps)
    for slot in PATTERNS.of("gradient"):
        axis = "xyz".index(PATTERNS.patterns[slot].axis)
        images[slot] = np.where(SEEN, albedo * (1 + 2 / 3 * world[..., axis]) / 2, 0)
    for slot in PATTERNS.of("constant", "tracking"):
        images[slot] = np.where(SEEN, albedo, 0)
    return images


def test_gradients_give_normals_exactly_and_full_confidence():
    found = gradient_normals(lamp_pictures(), PATTERNS, R_VIEW_LAMPS)
    assert angle(found.normals, SEEN).max() < 1e-4
    np.testing.assert_allclose(found.confidence[SEEN], 1, atol=1e-9)
    assert not found.known[~SEEN].any()
    np.testing.assert_allclose(found.albedo[SEEN], 0.5)


def test_where_half_the_lamps_are_hidden_confidence_falls():
    images = lamp_pictures()
    images[PATTERNS.of("gradient", axis="x")[0], :, :80] *= 0.5
    confidence = gradient_normals(images, PATTERNS, R_VIEW_LAMPS).confidence
    assert confidence[:, :70][SEEN[:, :70]].mean() < 0.75 * confidence[:, 90:][SEEN[:, 90:]].mean()


def test_a_missing_condition_is_named():
    from dataclasses import replace

    fewer = replace(PATTERNS, patterns=tuple(p for p in PATTERNS.patterns if p.axis != "z"))
    with pytest.raises(BadInput, match="x, y and z"):
        gradient_normals(np.ones((11, 4, 4)), fewer, R_VIEW_LAMPS)


def test_lamps_one_at_a_time_with_a_highlight_and_a_shadow():
    rays = pixel_rays(LEFT.camera)
    points = np.nan_to_num(rays * DEPTH[..., None])
    places = [(-300, 0, 100), (300, 0, 100), (0, -300, 100), (0, 300, 50), (200, 200, 0), (-200, -200, 0)]
    lamps = [PointLamp(place, 4e5, axis=(0, 0, 1.0), mu=1.0) for place in places]
    lamps.append(PointLamp((0.2, 0.1, -1.0), 0.6, far=True))
    images = np.stack([np.clip((lamp.light(points) * np.nan_to_num(NORMALS)).sum(-1), 0, None) for lamp in lamps]) * 0.5
    images[0, 90:110, 70:90] += 0.5
    images[1, 60:80] *= 0.0
    mask = SEEN & ((NORMALS * rays).sum(-1) < -0.5)
    found = photometric_normals(images, lamps, points, mask)
    assert np.median(angle(found.normals, mask & found.known)) < 0.5
    assert np.percentile(angle(found.normals, mask & found.known), 95) < 3
    np.testing.assert_allclose(np.nanmedian(found.albedo), 0.5, rtol=0.02)
    with pytest.raises(BadInput, match="3 lamps"):
        photometric_normals(images[:2], lamps[:2], points, mask)


def glossy(share):
    """Normals of the ball as gradients show them when a share of the light is mirrored."""
    rays = pixel_rays(LEFT.camera)
    sight = -rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    mirrored = 2 * (NORMALS * sight).sum(-1, keepdims=True) * NORMALS - sight
    mixed = (1 - share) * 2 / 3 * NORMALS + share * mirrored
    mixed /= np.linalg.norm(mixed, axis=-1, keepdims=True)
    flat = np.ones(mixed.shape[:2])
    return NormalMap(mixed, flat, flat), rays


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_highlights_are_taken_out_by_the_shape_that_geometry_tells(share):
    light, rays = glossy(share)
    rng = np.random.default_rng(0)
    rough = NORMALS + 0.1 * rng.normal(size=NORMALS.shape)
    rough /= np.linalg.norm(rough, axis=-1, keepdims=True)
    before, after = median_off(light.normals), median_off(without_highlights(light, rough, rays).normals)
    assert before > 20 * share
    assert after < 0.15 * before
    left = without_highlights(light, rough, rays, GlossConfig(window_px=0.0))
    assert left is light


def test_matt_skin_keeps_its_normals():
    light, rays = glossy(0.0)
    assert median_off(without_highlights(light, NORMALS, rays).normals) < 0.01


def median_off(normals):
    cosine = (normals * NORMALS).sum(-1)
    return np.degrees(np.median(np.arccos(np.clip(cosine[np.isfinite(cosine)], -1, 1))))
