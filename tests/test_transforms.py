import numpy as np
import pytest

from mien.transforms import (
    Transform,
    quaternions_from_rotations,
    rotation_from_vector,
    rotation_looking_along,
    rotations_from_quaternions,
    vector_from_rotation,
)

RNG = np.random.default_rng(0)


def some_transform(scale: float = 1.0) -> Transform:
    return Transform(rotation_from_vector(RNG.normal(size=3)), RNG.normal(size=3) * 50, scale)


def test_quarter_turn_about_z_takes_x_to_y():
    T = Transform(rotation_from_vector(np.array([0, 0, np.pi / 2])), np.array([1.0, 2, 3]), scale=2.0)
    np.testing.assert_allclose(T.apply(np.array([[1.0, 0, 0]])), [[1, 4, 3]], atol=1e-12)


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_inverse_undoes(scale):
    T, points = some_transform(scale), RNG.normal(size=(7, 3))
    np.testing.assert_allclose(T.inverse().apply(T.apply(points)), points, atol=1e-10)
    np.testing.assert_allclose((T @ T.inverse()).apply(points), points, atol=1e-10)


def test_product_is_one_after_the_other():
    a, b, points = some_transform(2.0), some_transform(0.5), RNG.normal(size=(7, 3))
    np.testing.assert_allclose((a @ b).apply(points), a.apply(b.apply(points)), atol=1e-10)


def test_batch_is_frame_by_frame():
    frames = [some_transform() for _ in range(4)]
    T = Transform(np.stack([f.rotation for f in frames]), np.stack([f.translation for f in frames]))
    points = RNG.normal(size=(4, 5, 3))
    np.testing.assert_allclose(T.apply(points), [f.apply(p) for f, p in zip(frames, points, strict=True)], atol=1e-12)
    np.testing.assert_allclose(T[2].apply(points[2]), frames[2].apply(points[2]), atol=1e-12)
    assert len(T) == 4


@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-4, 1.0, 3.1])
def test_rotation_vector_round_trip(angle):
    v = RNG.normal(size=(6, 3))
    v *= angle / np.linalg.norm(v, axis=1, keepdims=True)
    R = rotation_from_vector(v)
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
    np.testing.assert_allclose(vector_from_rotation(R), v, atol=1e-7)


def test_quaternions_turn_back_and_do_not_jump():
    turns = np.linspace(0, 3 * np.pi, 50)[:, None] * np.array([[0.0, 0, 1]])
    R = rotation_from_vector(turns)
    q = quaternions_from_rotations(R)
    np.testing.assert_allclose(rotations_from_quaternions(q), R, atol=1e-12)
    assert (np.sum(q[1:] * q[:-1], axis=1) > 0).all()


def test_a_camera_looks_along_a_direction_upright():
    R = rotation_looking_along(np.array([0.6, 0.0, -0.8]))
    np.testing.assert_allclose(R @ [0.6, 0.0, -0.8], [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(R @ [0.0, 1.0, 0.0], [0, -1, 0], atol=1e-12)
    for forward in (np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])):
        R = rotation_looking_along(forward)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose([np.linalg.det(R), *(R @ forward)], [1, 0, 0, 1], atol=1e-12)
