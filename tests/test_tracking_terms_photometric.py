"""The photometric term: a face that turns sideways into a picture of itself is put back by its texture."""

import numpy as np

import tracking_stage as stage
from mien._kernels import track_photo
from mien.tracking.terms.photometric import (
    PhotometricConfig,
    contrasts,
    learn_reference,
    no_reference,
    photometric_match,
    with_less_head,
)


def test_a_box_is_the_mean_of_what_lies_inside():
    image = np.random.default_rng(0).normal(size=(7, 9)).astype(np.float32)
    found = track_photo.box(image, 2)
    for i, j in ((0, 0), (3, 4), (6, 8), (1, 7)):
        expected = image[max(i - 2, 0) : i + 3, max(j - 2, 0) : j + 3].mean()
        np.testing.assert_allclose(found[i, j], expected, atol=1e-5)


def test_rows_lead_back_to_where_the_reference_was_seen():
    """Texture on a plane before the camera, points shifted by half a millimetre: one solve brings them back."""
    camera, rng, config = stage.CAMERA, np.random.default_rng(1), PhotometricConfig()
    x, y = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    wave = 128 + 60 * np.sin(x / 5.0) * np.cos(y / 6.0)
    color = np.repeat(wave[..., None], 3, 2).astype(np.uint8)
    intrinsics = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    points = np.column_stack([rng.uniform(-60, 60, (400, 2)), np.full(400, 600.0)]).astype(np.float32)
    normals = np.tile(np.array([0, 0, -1], np.float32), (400, 1))
    image, ones = contrasts(color, config)[0], np.ones(400, np.float32)
    shown = photometric_match(points, normals, image, intrinsics, ones, ones, config)[3]
    moved = points + np.array([0.5, -0.3, 0], np.float32)
    found, plane, weight, _ = photometric_match(moved, normals, image, intrinsics, shown, ones, config)
    right = ((found - moved) * plane).sum(1)
    step = np.linalg.lstsq(plane[:, :2][weight > 0], right[weight > 0], rcond=None)[0]
    np.testing.assert_allclose(step, [-0.5, 0.3], atol=0.1)


def test_skin_that_does_not_keep_its_look_is_trusted_less():
    """Of two halves of a face the one that flickers in the first frames loses its say."""
    config, m, T = PhotometricConfig(noise=0.01), stage.model(), stage.pose()
    reference = no_reference(len(m.front), config)
    camera = stage.CAMERA
    half = np.arange(camera.width) < camera.project(T.apply(m.centre[None]))[0, 0]
    intrinsics = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    for flicker in (0.1, -0.1) * 4:
        image = np.broadcast_to(np.where(half, flicker, 0.02).astype(np.float32), (camera.height, camera.width))
        reference = learn_reference(reference, (image, image), intrinsics, m.neutral, m.faces, None, T, config)
    trust = reference.weight(0, config)
    seen = reference.count == 8
    at = camera.project(T.apply(m.neutral.astype(float)))[:, 0].astype(int)
    assert np.abs(trust[seen & half[at - 2] & half[at + 2]] - 0.01**2 / (0.01**2 + 0.1**2)).max() < 1e-3
    assert trust[seen & ~half[at - 2]].min() > 0.99
    assert not trust[reference.count == 0].any()


def test_nothing_is_learnt_after_the_first_frames_or_without_colour():
    config, m = PhotometricConfig(frames=0), stage.model()
    empty = no_reference(len(m.front), config)
    T = stage.pose()
    assert learn_reference(empty, (), None, m.neutral, m.faces, None, T, config) is empty
    assert learn_reference(empty, None, None, m.neutral, m.faces, None, T, PhotometricConfig()) is empty


def test_without_a_say_in_the_head_shapes_are_told_as_they_would_be_with_the_best_pose():
    """Eliminating the pose leaves the shapes' least squares as it was, and nothing for the pose."""
    rng = np.random.default_rng(3)
    J, right = rng.normal(size=(40, 11)), rng.normal(size=40)
    A, b = with_less_head(J.T @ J, J.T @ right, 0.0)
    expected = np.linalg.lstsq(J, right, rcond=None)[0][:5]
    np.testing.assert_allclose(np.linalg.solve(A[:5, :5], b[:5]), expected, atol=1e-6)
    assert not A[5:].any()
    assert not A[:, 5:].any()
    assert not b[5:].any()


def test_between_a_whole_say_and_none_the_equations_go_straight():
    rng = np.random.default_rng(4)
    J, right = rng.normal(size=(40, 11)), rng.normal(size=40)
    whole, none, part = (with_less_head(J.T @ J, J.T @ right, share) for share in (1.0, 0.0, 0.1))
    np.testing.assert_array_equal(whole[0], J.T @ J)
    for all_of_it, without, some in zip(whole, none, part, strict=True):
        np.testing.assert_allclose(some, 0.1 * all_of_it + 0.9 * without, atol=1e-9)


def test_where_nothing_is_seen_the_head_is_not_asked():
    A, b = with_less_head(np.zeros((11, 11)), np.zeros(11), 0.0)
    assert not A.any()
    assert not b.any()
