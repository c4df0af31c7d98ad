"""The triangle mesh, and points fixed on it."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int, UInt8

from ..one_line import count, one_line


@dataclass(frozen=True)
class Mesh:
    """Triangles. Vertex order is meaning: two meshes with the same `faces` correspond vertex by vertex."""

    vertices: Float[np.ndarray, "n 3"]
    """Millimetres."""
    faces: Int[np.ndarray, "m 3"]
    """Vertex indices, counter-clockwise seen from outside."""
    uv: Float[np.ndarray, "u 2"] | None = None
    """Texture coordinates, origin at the lower left of the image (as OBJ; glTF is turned at its door)."""
    uv_faces: Int[np.ndarray, "m 3"] | None = None
    """Indices into `uv`, corner by corner; None where uv goes with the vertices one to one."""
    colors: Float[np.ndarray, "n 3"] | None = None
    """Vertex colours, sRGB in 0..1."""

    def __repr__(self) -> str:
        colours = "" if self.colors is None else "vertex colours"
        uv = "" if self.uv is None else "uv"
        return one_line(self, count(len(self.vertices), "vertices"), count(len(self.faces), "faces"), uv, colours)

    def __post_init__(self):
        if len(self.faces) and (self.faces.min() < 0 or self.faces.max() >= len(self.vertices)):
            raise ValueError(
                f"faces: expected vertex indices in 0..{len(self.vertices) - 1}, "
                f"got {self.faces.min()}..{self.faces.max()}"
            )

    def with_vertices(self, vertices: Float[np.ndarray, "n 3"]) -> "Mesh":
        """The same surface in another shape.

        Raises:
            ValueError: another number of vertices.
        """
        if vertices.shape != self.vertices.shape:
            raise ValueError(f"vertices: expected shape {self.vertices.shape}, got {vertices.shape}")
        return replace(self, vertices=vertices)


@dataclass(frozen=True)
class Attachment:
    """Points fixed on a surface: markers or landmarks. The papers' matrix D, kept as triangles and weights."""

    faces: Int[np.ndarray, " p"]
    """The triangle under each point."""
    barycentric: Float[np.ndarray, "p 3"]
    """Its weights on that triangle's corners; they add up to 1."""

    def __repr__(self) -> str:
        return one_line(self, count(len(self.faces), "points"))

    def matrix(self, mesh: Mesh) -> sp.csr_matrix:
        """D (p, n), sparse: `D @ vertices` are the points (Huang 2011, eq. 2)."""
        p = len(self.faces)
        rows = np.repeat(np.arange(p), 3)
        columns = mesh.faces[self.faces].ravel()
        return sp.csr_matrix((self.barycentric.ravel(), (rows, columns)), shape=(p, len(mesh.vertices)))

    def points(self, mesh: Mesh) -> Float[np.ndarray, "p 3"]:
        """Where the points are on `mesh`, in millimetres."""
        return np.einsum("pc,pcd->pd", self.barycentric, mesh.vertices[mesh.faces[self.faces]])


def submesh(mesh: Mesh, keep_faces: np.ndarray) -> tuple[Mesh, Int[np.ndarray, " k"]]:
    """The triangles of `keep_faces` (mask or indices) as a mesh of its own, and its vertices' old indices."""
    faces = mesh.faces[keep_faces]
    old, new = np.unique(faces, return_inverse=True)
    uv_faces = None if mesh.uv_faces is None else mesh.uv_faces[keep_faces]
    uv = mesh.uv[old] if mesh.uv is not None and mesh.uv_faces is None else mesh.uv
    colors = None if mesh.colors is None else mesh.colors[old]
    return Mesh(mesh.vertices[old], new.reshape(-1, 3), uv, uv_faces, colors), old


@dataclass(frozen=True)
class Scan:
    """A captured surface with its colour: its own topology, its own frame."""

    mesh: Mesh
    """Millimetres."""
    texture: UInt8[np.ndarray, "h w 3"] | None = None
    """sRGB image for the mesh's uv; None where colours are on the vertices or nowhere."""
    name: str = ""
    """What messages and files call it: the file's stem."""

    def __repr__(self) -> str:
        texture = None if self.texture is None else "texture of {1} x {0} pixels".format(*self.texture.shape)
        return one_line(self, self.name, self.mesh, texture)
