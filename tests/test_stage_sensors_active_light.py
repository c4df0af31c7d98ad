import numpy as np
import pytest

from mien.camera import Camera
from mien.mesh import Mesh
from mien.stage.sensors.active_light import ActiveLightConfig, Placed, Slot, look, picture
from mien.transforms import Transform

CLEAN = ActiveLightConfig(read_noise=0, shot_noise=0, bits=16, ambient=0, subsurface_mm=0, exposure=1.0)
BACK = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 500.0]))
VIEW = Placed(Camera(300, 300, 50, 40, 100, 80), BACK)
BEAMER = Placed(Camera(300, 300, 50, 40, 100, 80), BACK)


def wall(tilt=0.0):
    x, y = np.meshgrid([-60.0, 60.0], [-50.0, 50.0])
    vertices = np.stack([x, y, tilt * x], -1).reshape(-1, 3)
    return Mesh(vertices, np.array([[0, 1, 2], [1, 3, 2]]), colors=np.ones((4, 3)))


def shot(slot, config=CLEAN, mesh=None):
    mesh = mesh or wall()
    return picture(look(mesh, VIEW), mesh, BEAMER, slot, config, np.random.default_rng(0))


def test_a_camera_at_the_projector_sees_the_pattern_itself():
    ramp = np.linspace(0.2, 0.8, 100)
    seen = shot(Slot(columns=ramp))
    cosine = 500 / np.sqrt(500**2 + (500 / 300 * (np.arange(100) - 50)) ** 2)
    np.testing.assert_allclose(seen[40, 20:80], (ramp * cosine)[20:80], atol=1e-3)
    rows = np.linspace(0.3, 0.9, 80)
    assert np.corrcoef(shot(Slot(rows=rows))[20:60, 50], rows[20:60])[0, 1] > 0.99


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_gradients_over_the_even_light_give_the_normal(tilt):
    mesh = wall(tilt)
    normal = np.array([-tilt, 0, 1]) / np.hypot(tilt, 1)
    even = shot(Slot(gradient=(0, 0, 0)), mesh=mesh)[40, 50]
    for axis in range(3):
        slot = Slot(gradient=tuple(float(axis == i) for i in range(3)))
        assert 1.5 * (2 * shot(slot, mesh=mesh)[40, 50] / even - 1) == pytest.approx(normal[axis], abs=1e-3)


def test_what_stands_before_the_projector_throws_a_shadow():
    mesh = wall()
    front = np.array([[-8.0, -50, 60], [8, -50, 60], [-8, 50, 60], [8, 50, 60]])
    both = Mesh(np.vstack([mesh.vertices, front]), np.vstack([mesh.faces, mesh.faces + 4]), colors=np.ones((8, 3)))
    aside = Placed(BEAMER.camera, Transform(BACK.rotation, np.array([120.0, 0.0, 500.0])))
    seen = picture(look(both, VIEW), both, aside, Slot(columns=np.ones(100)), CLEAN, np.random.default_rng(0))
    assert (seen[40, 20:80] == 0).any()


def test_each_fault_shows():
    ramp = Slot(columns=np.tile([0.0, 0.0, 1.0, 1.0], 25))
    clean = shot(ramp)
    noisy = shot(ramp, ActiveLightConfig(read_noise=0.02, shot_noise=0, ambient=0, subsurface_mm=0, exposure=1.0))
    assert 0.01 < (noisy - clean)[20:60, 20:80].std() < 0.03
    assert shot(ramp, ActiveLightConfig(0, 0, 16, 1.0, 0.1, 0, 0, 1.0))[40, 40:60].min() == pytest.approx(0.1, abs=0.01)
    assert shot(ramp, ActiveLightConfig(0, 0, 16, 2.2, 0, 0, 0, 0.5)).max() > clean.max() * 0.5
    blurred = shot(ramp, ActiveLightConfig(0, 0, 16, 1.0, 0, 0, 4.0, 1.0))
    assert np.ptp(blurred[40, 40:60]) < 0.5 * np.ptp(clean[40, 40:60])
    shiny = shot(ramp, ActiveLightConfig(0, 0, 16, 1.0, 0, 0.3, 0, 0.5))
    assert shiny[40, 50] > 0.5 * clean[40, 50]
    assert len(np.unique(shot(ramp, ActiveLightConfig(0, 0, 2, 1.0, 0, 0, 0, 1.0)))) <= 4
