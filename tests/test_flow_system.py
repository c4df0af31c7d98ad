"""One level of the flow: its energy, gradient and sweeps."""

from dataclasses import replace

import numpy as np
from scipy import ndimage

from mien.flow import FlowConfig, FlowConstraints, Level, optical_flow, warp
from mien.flow.checkerboard import framed, unpack
from mien.flow.system import LevelSystem
from textures import CLEAN, Texture, pair, shift, sine


def _level(rng, h=16, w=20):
    source, target = rng.standard_normal((2, h, w, 2)).astype(np.float32)
    source, target = ndimage.gaussian_filter(source, (2, 2, 0)), ndimage.gaussian_filter(target, (2, 2, 0))
    weight = rng.random((h, w)).astype(np.float32)
    weight[:3], weight[-3:], weight[:, :3], weight[:, -3:] = 0, 0, 0, 0
    return Level(source, target, weight, np.ones_like(weight))


def _system(config, constraints=None):
    rng = np.random.default_rng(8)
    system = LevelSystem(_level(rng), constraints, config)
    flow = ndimage.gaussian_filter(rng.standard_normal((2, 16, 20)), (0, 3, 3)).astype(np.float32) * 3 + 0.3
    return system, flow


HELD = FlowConstraints(np.array([[5.3, 7.8], [12.0, 4.0]]), np.array([[6.0, 8.0], [12.0, 3.0]]))


def test_gradient_of_the_energy():
    """The frozen system at the point of linearisation has the gradient of the true energy."""
    config = FlowConfig(source_share=0.0, turn_gradients=False)
    system, flow = _system(config, HELD)

    def energy(flow):
        u, v = framed(flow[0]), framed(flow[1])
        system.linearise(u, v)
        return system.freeze(u, v)

    energy(flow)
    gradient = _gradient(system, flow)
    rng = np.random.default_rng(1)
    for _ in range(5):
        direction = ndimage.gaussian_filter(rng.standard_normal((2, 16, 20)), (0, 1, 1)).astype(np.float32)
        step = np.float32(2e-3)
        difference = (energy(flow + step * direction) - energy(flow - step * direction)) / (2 * step)
        np.testing.assert_allclose(difference, (gradient * direction).sum(), rtol=2e-2)


def _gradient(system, flow):
    """A w - b of the frozen system, as an image."""
    a11, a12, a22 = (unpack(system.a[:, i]) for i in range(3))
    b1, b2 = (unpack(system.b[:, i]) for i in range(2))
    edges = np.array([unpack(system.edges[:, i]) for i in range(4)])
    wide = np.pad(flow, ((0, 0), (1, 1), (1, 1)), mode="edge")
    around = np.array([wide[:, 1:-1, :-2], wide[:, 1:-1, 2:], wide[:, :-2, 1:-1], wide[:, 2:, 1:-1]])
    smooth = (edges[:, None] * (flow - around)).sum(0)
    return smooth + np.array([a11 * flow[0] + a12 * flow[1] - b1, a12 * flow[0] + a22 * flow[1] - b2])


def test_energy_falls_with_every_sweep():
    for config in (FlowConfig(), FlowConfig(overrelaxation=1.0), FlowConfig(brightness=1.0, overrelaxation=1.95)):
        system, flow = _system(config, HELD)
        u, v = framed(flow[0]), framed(flow[1])
        system.linearise(u, v)
        energies = []
        for _ in range(25):
            energies.append(system.freeze(u, v))
            system.sweep(u, v, 1, config.overrelaxation)
        falls = np.diff(energies)
        assert (falls <= 1e-5 * energies[0]).all()
        assert energies[-1] < 0.9 * energies[0]


def test_energy_falls_in_every_inner_solve():
    result = optical_flow(*pair(Texture(12), sine(2.0, 70.0)), config=FlowConfig(inner=4))
    assert len(result.energy) == len(result.iterations) == 4
    for energy, warps in zip(result.energy, result.iterations, strict=True):
        assert energy.shape == (warps, 4)
        assert (np.diff(energy, axis=1) <= 1e-6 * energy[:, :1]).all()
        assert energy[-1, 0] < energy[0, 0]


def test_residual_is_the_difference_of_the_images():
    source, target = pair(Texture(13), shift(0.6, 0.2))
    target = target + 0.25
    result = optical_flow(source, target, config=replace(CLEAN, presmooth=0.0, brightness=0.0))
    known = np.abs(warp(target, result.flow) - source)
    np.testing.assert_allclose(result.residual[8:-8, 8:-8], known[8:-8, 8:-8], atol=1e-3)
