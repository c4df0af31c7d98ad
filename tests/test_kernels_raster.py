"""Scan conversion against its numpy twin."""

import numpy as np

from mien._kernels import raster as kernels
from mien._kernels import raster_twin as twins
from nets import net


def test_kernel_and_twin_agree():
    places, faces = net(np.random.default_rng(1))
    faces[3] = faces[3, ::-1]
    places[0] = places[1]
    results = []
    for module in (kernels, twins):
        owner, bary = np.full((20, 20), -1, np.int64), np.zeros((20, 20, 3))
        module.scan_convert(places, faces, owner, bary)
        results.append((owner, bary))
    np.testing.assert_array_equal(results[0][0], results[1][0])
    np.testing.assert_allclose(results[0][1], results[1][1], atol=1e-9)
