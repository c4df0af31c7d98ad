"""What several scans agree on about a marker's place and height."""

import numpy as np

from mien.mesh import Mesh, vertex_normals
from mien.scans.marker_consensus import consensus_attachment, consensus_standoff
from small_scans import markers_on, plain_template, sheet


def test_the_median_of_the_scans_outvotes_one_that_errs_and_heights_are_means():
    mesh = sheet()
    template, place = plain_template(mesh), markers_on(mesh)
    skins = np.stack([mesh.vertices + np.array([0, 0, 2.0 * i]) for i in range(3)])
    points = [place.points(mesh.with_vertices(x)) for x in skins]
    points[0] = points[0] + [4.0, 0.0, 0.0]
    covered = np.ones((3, len(place.faces)), bool)
    found = consensus_attachment(template, skins, points, covered).points(mesh)
    np.testing.assert_allclose(found, place.points(mesh), atol=0.5)
    alone = consensus_attachment(template, skins[:1], points[:1], covered[:1]).points(mesh)
    assert np.abs(alone - place.points(mesh))[:, 0].mean() > 2.0
    normals = place.points(Mesh(vertex_normals(mesh.vertices, mesh.faces), mesh.faces))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    below = np.stack([place.points(mesh.with_vertices(x)) for x in skins])
    above = below + np.array([1.0, 3.0, 9.0])[:, None, None] * normals
    covered[2], covered[:, 0] = False, False
    heights = consensus_standoff(template, skins, place, above, covered, np.full(len(place.faces), 7.0))
    np.testing.assert_allclose(heights[1:], 2.0, atol=1e-6)
    assert heights[0] == 7.0
