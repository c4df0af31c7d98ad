"""Scans in and meshes out: OBJ, PLY, STL, GLB."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from ...errors import BadInput
from ...files import existing
from ...mesh import Mesh, Scan
from ...units import parse_unit
from ..gltf.glb import damage_told, open_glb
from ..gltf.mesh import read_surface
from ..gltf.scene import drawn_parts
from .images import read_image
from .obj import read_obj, write_obj
from .ply import read_ply, write_ply
from .polygons import weld
from .stl import read_stl
from .texture_pages import Pages, read_pages

Picture = Path | Pages | None
"""Where a mesh's colours are: one picture, several pages, or none."""
READERS: dict[str, Callable[[Path], tuple[Mesh, Picture]]] = {".obj": read_obj, ".ply": read_ply, ".stl": read_stl}
WRITERS: dict[str, Callable[[Path, Mesh, UInt8[np.ndarray, "h w 3"] | None], None]] = {
    ".obj": write_obj,
    ".ply": write_ply,
}
SUFFIXES = (*READERS, ".glb")


def read_scan(path: str | Path, unit: str | None = None) -> Scan:
    """Read a scan from `.obj`, `.ply`, `.stl` or `.glb`: millimetres, the file's own axes, named after the file's stem.

    OBJ and PLY keep their vertices and order exactly. STL and GLB store a point once for every triangle or seam that
    meets there: equal ones become one.

    Args:
        path: the file.
        unit: "mm", "cm", "m", "in" or millimetres in one unit as a number. By default millimetres, but metres for GLB.

    Raises:
        BadInput: missing, unknown suffix, damaged, cut off, no triangles (a point cloud), a vertex that is not finite.
    """
    path = existing(path)
    suffix = path.suffix.lower()
    if suffix == ".glb":
        mesh, texture = _read_glb(path)
        mm = 1.0 if unit is None else parse_unit(unit) / 1000.0
    elif suffix in READERS:
        mesh, picture = READERS[suffix](path)
        texture = _read_picture(picture)
        mm = 1.0 if unit is None else parse_unit(unit)
    else:
        kind = path.suffix or "a file without suffix"
        raise BadInput(f"{path}: cannot read {kind} as a scan; give one of {' '.join(SUFFIXES)}")
    mesh = without_stray_vertices(mesh)
    check_surface(path, mesh)
    return Scan(replace(mesh, vertices=mesh.vertices * mm), texture, path.stem)


def write_mesh(path: str | Path, mesh: Mesh, texture: UInt8[np.ndarray, "h w 3"] | None = None) -> None:
    """Write `.obj` or `.ply` by the suffix, millimetres.

    Raises:
        BadInput: another suffix, or the folder does not exist.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        kind = path.suffix or "a file without suffix"
        raise BadInput(f"{path}: cannot write {kind} as a mesh; use {' or '.join(WRITERS)}")
    writer(path, mesh, texture)


def without_stray_vertices(mesh: Mesh) -> Mesh:
    """The mesh without vertices that are not finite and that no triangle uses: exporters leave them behind."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    kept = used | np.isfinite(mesh.vertices).all(axis=1)
    if kept.all() or not len(mesh.faces):
        return mesh
    number = np.cumsum(kept) - 1
    uv = mesh.uv[kept] if mesh.uv is not None and mesh.uv_faces is None else mesh.uv
    colors = None if mesh.colors is None else mesh.colors[kept]
    return Mesh(mesh.vertices[kept], number[mesh.faces], uv, mesh.uv_faces, colors)


def check_surface(path: Path, mesh: Mesh) -> None:
    """Refuse what is no surface.

    Raises:
        BadInput: no vertices, no triangles, a vertex that is not finite.
    """
    if len(mesh.vertices) == 0:
        raise BadInput(f"{path}: is empty: it has no vertices")
    if len(mesh.faces) == 0:
        raise BadInput(f"{path}: has {len(mesh.vertices)} points but no triangles; mesh the point cloud first")
    finite = np.isfinite(mesh.vertices).all(axis=1)
    if not finite.all():
        wrong = np.flatnonzero(~finite)
        raise BadInput(f"{path}: {len(wrong)} vertices are not finite, the first is number {wrong[0]}; clean the mesh")


def _read_picture(picture: Picture) -> UInt8[np.ndarray, "h w 3"] | None:
    if isinstance(picture, tuple):
        return read_pages(picture)
    return None if picture is None else read_image(picture)


def _read_glb(path: Path) -> tuple[Mesh, UInt8[np.ndarray, "h w 3"] | None]:
    glb = open_glb(path)
    with damage_told(path):
        parts = drawn_parts(glb)
        if not parts:
            return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64)), None
        surface = read_surface(glb, [part for part, _ in parts], [matrix for _, matrix in parts])
        mesh, _ = surface.mesh(weld(surface.vertices) if surface.source is None else surface.source)
    return mesh, surface.texture


__all__ = ["check_surface", "read_obj", "read_ply", "read_scan", "read_stl", "write_mesh", "write_obj", "write_ply"]
