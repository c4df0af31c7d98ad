"""Performances as Alembic (`.abc`): every vertex in every frame. Needs the extra `alembic`.

Metres, +Y up (Alembic knows no units; Maya wants centimetres: scale by 100 at its import). Faces are stored clockwise,
as Alembic's readers expect. Time 0 is the first frame. Texture coordinates go corner by corner.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..extras import require
from ..files import whole
from ..mesh import Mesh
from ..progress import SILENT, Progress
from ..rig import Performance
from .gltf.mesh import MM

SUFFIX = ".abc"


def write_alembic(path: str | Path, performance: Performance, world: bool = True, progress: Progress = SILENT) -> None:
    """Write a point cache, one frame at a time in memory. With `world` the head moves as in the take.

    Raises:
        BadInput: the extra is missing, or the folder does not exist.
    """
    require("alembic3d", "alembic")
    import imath
    from alembic3d import Abc, AbcCoreAbstract, AbcGeom

    clock = AbcCoreAbstract.TimeSampling(1.0 / performance.rate, 0.0)
    faces, counts, uv = _topology(performance.rig.neutral)
    sides = AbcGeom.OV2fGeomParamSample(uv, AbcGeom.GeometryScope.kFacevaryingScope) if uv is not None else None
    with whole(path) as temporary:
        archive = Abc.CreateArchiveWithInfo(str(temporary), performance.rate, "mien", "a face in motion")
        cache = AbcGeom.OPolyMesh(archive.getTop(), "face")
        schema = cache.getSchema()
        schema.setTimeSampling(clock)
        for t, mesh in enumerate(performance.meshes(world=world)):
            points = imath.V3fArrayFromBuffer(np.ascontiguousarray(mesh.vertices * MM, np.float32))
            if t == 0:
                sample = AbcGeom.OPolyMeshSchemaSample(points, faces, counts, *([sides] if sides is not None else []))
            else:
                sample = AbcGeom.OPolyMeshSchemaSample()
                sample.setPositions(points)
            schema.set(sample)
            progress.update("write frames", t + 1, len(performance))
        del sample, schema, cache, archive  # which writes the file's end


def _topology(mesh: Mesh) -> tuple[Any, Any, Any]:
    """Corners' vertices, corners a face, texture coordinates a corner (None without), as arrays that Alembic takes.

    Its samples only point to them: they must outlive the file.
    """
    import imath

    clockwise = np.ascontiguousarray(mesh.faces[:, ::-1], np.int32).ravel()
    faces = imath.IntArrayFromBuffer(clockwise)
    counts = imath.IntArrayFromBuffer(np.full(len(mesh.faces), 3, np.int32))
    if mesh.uv is None:
        return faces, counts, None
    corners = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
    flat = np.ascontiguousarray(mesh.uv[corners[:, ::-1]].reshape(-1, 2), np.float32)
    return faces, counts, imath.V2fArrayFromBuffer(flat)
