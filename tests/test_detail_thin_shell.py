import numpy as np
import pytest

from detail_patch import marker_places, patch
from mien.detail.thin_shell import ShellConfig, thin_shell
from mien.errors import BadInput
from mien.mesh import Attachment


def test_markers_are_met_and_translations_pass_through():
    mesh = patch(17)
    at = marker_places(mesh)
    shell = thin_shell(mesh, at)
    step = np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        shell.vertices(np.tile(step, (25, 1))) - mesh.vertices, np.tile(step, (289, 1)), atol=1e-4
    )
    offsets = np.random.default_rng(1).normal(size=(25, 3))
    moved = mesh.with_vertices(shell.vertices(offsets))
    np.testing.assert_allclose(at.points(moved), at.points(mesh) + offsets, atol=1e-6)


def test_softness_lets_markers_go():
    mesh = patch(17)
    at = marker_places(mesh)
    offsets = np.zeros((25, 3))
    offsets[12, 2] = 1.0
    soft = thin_shell(mesh, at, ShellConfig(softness_mm=1.0))
    reached = (at.points(mesh.with_vertices(soft.vertices(offsets))) - at.points(mesh))[12, 2]
    assert 0.05 < reached < 0.95


def test_bending_rounds_what_a_membrane_leaves_pointed():
    mesh = patch()
    at = marker_places(mesh)
    lone = np.zeros((25, 1))
    lone[12] = 1.0
    near = np.linalg.norm(mesh.vertices - at.points(mesh)[12], axis=1) < 4.0
    flat, round_ = ((thin_shell(mesh, at, ShellConfig(bending_mm=b)).response @ lone)[near].mean() for b in (0.0, 20.0))
    assert round_ > flat + 0.1


def test_two_markers_on_one_spot_are_refused():
    mesh = patch(9)
    twice = Attachment(np.array([5, 5]), np.full((2, 3), 1 / 3))
    with pytest.raises(BadInput, match="one spot"):
        thin_shell(mesh, twice)
    with pytest.raises(BadInput, match="0 or more"):
        ShellConfig(bending_mm=-1)
