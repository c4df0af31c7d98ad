"""Triangle meshes: the noun, its operators, closest points."""

from .along_edges import nearest_along_edges
from .closest import Closest, ClosestPoint, barycentric, closest_point
from .curvature import curvature_features, mean_curvature
from .cylinder import Cylinder, Unrolled, fit_cylinder, unroll_face
from .mesh import Attachment, Mesh, Scan, submesh
from .operators import (
    adjacency,
    boundary_vertices,
    connected_parts,
    cotangent_laplacian,
    edge_ends,
    face_areas,
    face_normals,
    grid_faces,
    in_largest_part,
    mass,
    mean_edge_length,
    uniform_laplacian,
    vertex_normals,
)
from .raster import SurfaceImage
from .sample import blue_noise, farthest_points, random_points, transfer
from .subdivide import Refinement, loop_refinement, loop_subdivide, subdivided

__all__ = [
    "Attachment",
    "Closest",
    "ClosestPoint",
    "Cylinder",
    "Mesh",
    "Refinement",
    "Scan",
    "SurfaceImage",
    "Unrolled",
    "adjacency",
    "barycentric",
    "blue_noise",
    "boundary_vertices",
    "closest_point",
    "connected_parts",
    "cotangent_laplacian",
    "curvature_features",
    "edge_ends",
    "face_areas",
    "face_normals",
    "farthest_points",
    "fit_cylinder",
    "grid_faces",
    "in_largest_part",
    "loop_refinement",
    "loop_subdivide",
    "mass",
    "mean_curvature",
    "mean_edge_length",
    "nearest_along_edges",
    "random_points",
    "subdivided",
    "submesh",
    "transfer",
    "uniform_laplacian",
    "unroll_face",
    "vertex_normals",
]
