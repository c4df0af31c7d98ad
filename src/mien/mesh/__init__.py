"""Triangle meshes: the noun, its operators, closest points."""

from .closest import Closest, ClosestPoint, barycentric, closest_point
from .mesh import Attachment, Mesh, Scan, submesh
from .operators import (
    adjacency,
    boundary_vertices,
    cotangent_laplacian,
    face_areas,
    face_normals,
    mass,
    mean_edge_length,
    uniform_laplacian,
    vertex_normals,
)

__all__ = [
    "Attachment",
    "Closest",
    "ClosestPoint",
    "Mesh",
    "Scan",
    "adjacency",
    "barycentric",
    "boundary_vertices",
    "closest_point",
    "cotangent_laplacian",
    "face_areas",
    "face_normals",
    "mass",
    "mean_edge_length",
    "submesh",
    "uniform_laplacian",
    "vertex_normals",
]
