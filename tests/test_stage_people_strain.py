"""Compression of a sheet along a direction, by hand."""

import numpy as np
import pytest

from mien.mesh import Mesh
from mien.stage.people.strain import strain_gauge
from small_scans import sheet


@pytest.fixture(scope="module")
def flat():
    mesh = sheet(9)
    return mesh.with_vertices(mesh.vertices * [1, 1, 0])


def gauge(mesh: Mesh, along):
    used = np.arange(len(mesh.faces))
    return strain_gauge(mesh, used, np.tile(np.array(along, float), (len(used), 1)))


def compression(mesh: Mesh, along, vertices):
    return gauge(mesh, along).compression(vertices[None])[0]


def test_a_sheet_squeezed_along_x_is_compressed_there_alone(flat):
    squeezed = flat.vertices * [0.9, 1, 1]
    np.testing.assert_allclose(compression(flat, (1, 0, 0), squeezed), 0.1, atol=0.012)
    np.testing.assert_allclose(compression(flat, (0, 1, 0), squeezed), 0.0, atol=1e-9)


def test_rigid_motion_compresses_nothing(flat):
    turned = flat.vertices[:, [1, 0, 2]] * [-1, 1, 1] + 5.0
    np.testing.assert_allclose(compression(flat, (1, 0, 0), turned), 0.0, atol=1e-9)
    np.testing.assert_allclose(compression(flat, (1, 1, 0), flat.vertices), 0.0, atol=1e-9)
