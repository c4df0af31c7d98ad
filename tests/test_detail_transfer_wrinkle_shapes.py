import numpy as np
import pytest

from detail_patch import bent, patch, training
from mien.detail.base_mesh import BaseConfig
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.pipeline import synthesize
from mien.detail.synthesize import SynthesisConfig
from mien.detail.transfer.wrinkle_shapes import semi_nonnegative, with_wrinkles, wrinkle_shapes
from mien.errors import BadInput
from mien.rig import Performance, Rig
from mien.transforms import Transform

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=48, fine_size=96, high_pass_mm=4.0)
CONFIG = SynthesisConfig(levels=0, fine_vertices=True)


@pytest.fixture(scope="module")
def model():
    return fit_detail(training(), SMALL)


def performance(frames=20):
    """A rig that squeezes and shears the patch, in both orders."""
    mesh = patch(21)
    deltas = np.stack([bent(mesh.vertices, 0.2, 0) - mesh.vertices, bent(mesh.vertices, 0, 0.15) - mesh.vertices])
    t = np.linspace(0, 2 * np.pi, frames)
    weights = np.stack([0.5 - 0.5 * np.cos(t), 0.5 - 0.5 * np.cos(2 * t)], 1)
    rig = Rig(mesh, deltas, ("squeeze", "shear"))
    return Performance(rig, weights, Transform.identity(frames), 30.0, np.ones(frames, bool))


def test_played_with_clamped_weights_the_export_shows_the_synthesis(model):
    played = performance()
    exported, kept = with_wrinkles(model, played, CONFIG)
    assert kept > 0.9
    assert exported.weights.min() >= 0
    assert exported.weights.max() <= 1
    assert sum(name.startswith("wrinkle_") for name in exported.rig.names) <= 8
    _, drive, frames = synthesize(model, played, CONFIG)
    for frame, mesh, T in zip(frames, exported.meshes(), drive.T_lab_face, strict=True):
        np.testing.assert_allclose(mesh.vertices, T.apply(frame.vertices.astype(float)), atol=0.25)


def test_without_wrinkles_the_export_would_miss_them(model):
    _, wrinkles = wrinkle_shapes(model, performance(), CONFIG)
    assert np.abs(wrinkles.shapes).max() > 0.1
    np.testing.assert_allclose(wrinkles.weights(np.zeros((1, 2))), 0, atol=1e-9)


def test_factors_are_not_negative_and_reach_the_rank():
    rng = np.random.default_rng(2)
    A, B = rng.random((30, 4)), rng.normal(size=(4, 50))
    D = A @ B
    found = semi_nonnegative(D @ D.T, 4)
    assert found.min() >= 0
    left = D - found @ np.linalg.lstsq(found, D, rcond=None)[0]
    assert (left**2).sum() < 0.05 * (D**2).sum()


def test_a_face_that_never_moves_is_refused(model):
    still = performance()
    flat = Rig(still.rig.neutral, 0 * still.rig.deltas, still.rig.names)
    with pytest.raises(BadInput, match="never move"):
        with_wrinkles(model, Performance(flat, still.weights, still.T_world_face, 30.0, still.tracked), CONFIG)
