import numpy as np

import light_scene
from mien.light.fuse import NormalFusionConfig, corrected_normals, fuse, local_lean, small_holes, turned
from mien.light.normals import NormalMap
from mien.light.triangulate import DepthMap, pixel_rays, surface_normals
from mien.transforms import rotation_from_vector

LEFT = light_scene.rig().cameras[0]
DEPTH, NORMALS = light_scene.ball_depth(LEFT)
RAYS = pixel_rays(LEFT.camera)
with np.errstate(invalid="ignore"):
    SEEN = np.abs((NORMALS * RAYS).sum(-1)) / np.linalg.norm(RAYS, axis=-1) > 0.3


def angle(found):
    with np.errstate(invalid="ignore"):
        off = np.degrees(np.arccos(np.clip((found * NORMALS).sum(-1), -1, 1)))
    return off[SEEN & np.isfinite(off)]


def light(normals, confidence=1.0):
    return NormalMap(
        np.where(SEEN[..., None], normals, np.nan), np.where(SEEN, confidence, 0.0), np.where(SEEN, 0.5, np.nan)
    )


def test_normals_of_a_depth_map_point_to_the_camera():
    assert np.median(angle(surface_normals(np.where(SEEN, DEPTH, np.nan), LEFT.camera))) < 0.5


def test_noisy_depth_and_bent_normals_together_beat_both():
    rng = np.random.default_rng(0)
    noisy = np.where(SEEN, DEPTH + 0.5 * rng.normal(size=DEPTH.shape), np.nan)
    bent = NORMALS @ rotation_from_vector(np.array([0.05, 0.04, 0.0])).T
    depth = DepthMap(noisy, np.where(SEEN, 0.5, np.nan))
    fused = fuse(depth, light(bent), LEFT.camera)
    assert fused.solution.converged
    assert np.nanmean(np.abs(fused.z - DEPTH)) < 0.35 * np.nanmean(np.abs(noisy - DEPTH))
    assert np.median(angle(fused.normals)) < 0.7 * np.median(angle(bent))
    assert np.median(angle(fused.normals)) < 0.3 * np.median(angle(surface_normals(noisy, LEFT.camera)))
    uncorrected = fuse(depth, light(bent), LEFT.camera, NormalFusionConfig(smooth_px=0.0))
    assert np.median(angle(fused.normals)) < 0.9 * np.median(angle(uncorrected.normals))


def test_normals_that_lean_away_from_good_points_near_a_rim_do_not_pull_the_surface():
    with np.errstate(invalid="ignore"):
        rim = SEEN & (np.abs((NORMALS * RAYS).sum(-1)) / np.linalg.norm(RAYS, axis=-1) < 0.5)
    leaning = np.where(rim[..., None], NORMALS @ rotation_from_vector(np.array([0.0, 0.5, 0.0])).T, NORMALS)
    depth = DepthMap(np.where(SEEN, DEPTH, np.nan), np.where(SEEN, 0.05, np.nan))
    off = [
        np.nanmean(np.abs(fuse(depth, light(leaning), LEFT.camera, config).z - DEPTH)[rim])
        for config in (NormalFusionConfig(), NormalFusionConfig(differ=0.0))
    ]
    assert off[0] < 0.4 * off[1]


def test_normals_that_lean_for_a_while_leave_the_broad_shape_to_the_points():
    lean = 0.08 * np.sin(2 * np.pi * np.arange(160) / 40)[None, :, None] * np.array([1.0, 0, 0])
    leaning = (NORMALS + lean) / np.linalg.norm(NORMALS + lean, axis=-1, keepdims=True)
    noisy = DEPTH + 0.1 * np.random.default_rng(0).normal(size=DEPTH.shape)
    depth = DepthMap(np.where(SEEN, noisy, np.nan), np.where(SEEN, 0.1, np.nan))
    off = [
        np.nanmean(np.abs(fuse(depth, light(leaning), LEFT.camera, config).z - DEPTH))
        for config in (NormalFusionConfig(), NormalFusionConfig(lean=0.0))
    ]
    assert off[0] < 0.7 * off[1]
    assert off[0] < 0.7 * np.nanmean(np.abs(depth.z - DEPTH))


def test_how_a_surface_leans_beside_noisy_points_is_told_place_by_place():
    rng = np.random.default_rng(0)
    x = np.arange(160.0)
    z = np.where(x < 80, 0.0, 0.25 * (x - 80)) * np.ones((200, 1))
    z[:20] = np.nan
    told = local_lean(z, 0.02 * rng.normal(size=z.shape), pixel_mm=0.5)
    np.testing.assert_allclose(told[40:160, 110:140], 0.5, atol=0.02)
    assert told[40:160, 20:50].max() < 0.02


def test_a_step_in_depth_stays_a_step():
    z = np.where(np.arange(160) < 80, 500.0, 540.0) * np.ones((200, 1))
    flat = np.broadcast_to([0.0, 0.0, -1.0], (200, 160, 3)) - 0 * RAYS
    fused = fuse(DepthMap(z, np.full_like(z, 0.1)), NormalMap(flat, np.ones(z.shape), np.ones(z.shape)), LEFT.camera)
    assert np.abs(fused.z - z).max() < 0.5


def test_normals_bent_slowly_are_turned_back_and_their_detail_stays():
    ripple = 0.05 * np.sin(np.arange(160) * 2.0)[None, :, None] * np.array([1.0, 0, 0])
    bent = (NORMALS + ripple) @ rotation_from_vector(np.array([0.0, 0.1, 0.0])).T
    bent /= np.linalg.norm(bent, axis=-1, keepdims=True)
    found = corrected_normals(light(bent), np.where(SEEN[..., None], NORMALS, np.nan), RAYS, 6.0)
    assert np.median(angle(found)) < 0.5 * np.median(angle(bent))
    middle = found[100, 60:100, 0] - NORMALS[100, 60:100, 0]
    assert 0.02 < middle.std() < 0.06


def test_the_smallest_rotation_takes_source_to_target_and_keeps_lengths():
    rng = np.random.default_rng(1)
    vectors, source, target = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in rng.normal(size=(3, 20, 3)))
    np.testing.assert_allclose(turned(source, source, target), target, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(turned(vectors, source, target), axis=1), 1)


def test_small_holes_are_bridged_by_normals_and_large_ones_stay():
    z = np.where(SEEN, DEPTH, np.nan)
    z[100:105, 80:84] = np.nan
    z[60:90, 60:90] = np.nan
    fused = fuse(DepthMap(z, np.where(SEEN, 0.1, np.nan)), light(NORMALS), LEFT.camera)
    assert np.abs(fused.z - DEPTH)[100:105, 80:84].max() < 0.15
    assert np.isnan(fused.z[60:90, 60:90]).all()
    unbridged = fuse(
        DepthMap(z, np.where(SEEN, 0.1, np.nan)), light(NORMALS), LEFT.camera, NormalFusionConfig(hole_mm=0.0)
    )
    assert np.isnan(unbridged.z[100:105, 80:84]).all()
    assert not small_holes(np.full((4, 4), np.nan), LEFT.camera, 5.0).any()
