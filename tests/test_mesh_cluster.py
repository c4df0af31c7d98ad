"""Vertices thinned by cells."""

from mien.mesh import closest_point
from mien.mesh.cluster import clustered
from small_scans import sheet


def test_clustering_keeps_the_shape_and_thins_it():
    mesh = sheet(41)
    thin = clustered(mesh, 10.0)
    assert len(thin.vertices) < len(mesh.vertices) / 5
    assert closest_point(mesh, thin.vertices).distances.max() < 0.5
    assert (thin.faces[:, 0] != thin.faces[:, 1]).all()
