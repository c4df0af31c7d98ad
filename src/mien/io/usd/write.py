"""A rig, and what it plays, onto a USD stage."""

import shutil
import tempfile
from collections.abc import Iterable
from itertools import chain, islice
from pathlib import Path

import numpy as np
from jaxtyping import Float32
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils, Vt

from ...errors import BadInput
from ...files import whole
from ...rig import Performance, Rig
from ...rig.morph_normals import neutral_normals, normal_offsets
from ...transforms import quaternions_from_rotations
from ..gltf.mesh import MM, png_bytes
from .displacement import NAME as DISPLACEMENT
from .displacement import add_displacement, write_maps
from .material import add_material, linear_colors
from .motion import RATE, UNTRACKED
from .prim_names import prim_names

ROOT = Sdf.Path("/face")
SKIN = ROOT.AppendPath("materials/skin")
JOINT = "head"
_TEXTURE = ".base_color.png"
"""How the name of a face's picture ends, which lies beside it or in its package."""
Heights = Iterable[Float32[np.ndarray, "h w"]]
"""Displacement maps, mm, one a frame or one for all."""
_NOTHING_MM = 1e-6
"""Displacements below this are written as none: less than float32 can say about a position."""


def write_face(path: Path, rig: Rig, played: Performance | None, heights: Heights = ()) -> None:
    """Write a rig and, with `played` (on this rig, weights in 0..1), its animation; displacement maps one a frame."""
    if path.suffix.lower() == ".usdz":
        _write_package(path, rig, played, heights)
        return
    with whole(path) as temporary:
        _write_beside(path, temporary, rig, played, heights)


def _write_beside(path: Path, temporary: Path, rig: Rig, played: Performance | None, heights: Heights) -> None:
    """The stage at `temporary`, the pictures beside `path`, which it will be."""
    name, png = path.stem + _TEXTURE, _texture(rig)
    maps = _maps(path.with_name(f"{path.stem}.{DISPLACEMENT}"), heights)
    _export(_stage(rig, played, f"./{name}" if png else None, maps), temporary)
    if png:
        with whole(path.with_name(name)) as picture:
            picture.write_bytes(png)


def _maps(folder: Path, heights: Heights) -> list[str]:
    """Displacement maps written into a folder; their paths from beside it. Without any there is no folder."""
    first = list(islice(heights := iter(heights), 1))
    if not first:
        return []
    return [f"./{folder.name}/{name}" for name in write_maps(folder, chain(first, heights))]


def _texture(rig: Rig) -> bytes | None:
    """The base colour as PNG, of a rig that has one and knows where it goes."""
    return None if rig.texture is None or rig.neutral.uv is None else png_bytes(rig.texture)


def _write_package(path: Path, rig: Rig, played: Performance | None, heights: Heights) -> None:
    """A `.usdz`: an uncompressed archive of one `.usdc` and its pictures."""
    with whole(path) as temporary, tempfile.TemporaryDirectory() as folder:
        inside, packed = Path(folder) / "face.usdc", Path(folder) / "face.usdz"
        _write_beside(inside, inside, rig, played, heights)
        if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(inside)), str(packed)):
            raise BadInput(f"{path}: the package could not be written; try .usdc")
        shutil.copyfile(packed, temporary)


def _export(stage: Usd.Stage, path: Path) -> None:
    if not stage.GetRootLayer().Export(str(path)):
        raise OSError(f"{path}: cannot be written")


def _stage(rig: Rig, played: Performance | None, texture: str | None, maps: list[str]) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory(".usda")
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdSkel.Root.Define(stage, ROOT)
    Usd.ModelAPI(root.GetPrim()).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    normals = neutral_normals(rig)
    mesh = _mesh(stage, rig, normals)
    _bind(stage, mesh, rig)
    _shapes(stage, mesh, rig, normals)
    UsdGeom.Scope.Define(stage, ROOT.AppendChild("materials"))
    add_material(stage, mesh, SKIN, texture)
    if maps:
        add_displacement(stage, SKIN, maps)
    root.CreateExtentAttr(_extent(rig, played))
    if played is not None:
        _animate(stage, played)
    return stage


def _mesh(stage: Usd.Stage, rig: Rig, normals: np.ndarray) -> UsdGeom.Mesh:
    surface = rig.neutral
    mesh = UsdGeom.Mesh.Define(stage, ROOT.AppendChild("mesh"))
    points = _vectors(surface.vertices * MM)
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(surface.faces), 3))
    mesh.CreateFaceVertexIndicesAttr(_integers(surface.faces))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(points))
    mesh.CreateNormalsAttr(_vectors(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateDoubleSidedAttr(True)
    if surface.uv is not None:
        by_corner = surface.uv_faces is not None
        where = UsdGeom.Tokens.faceVarying if by_corner else UsdGeom.Tokens.vertex
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, where)
        st.Set(Vt.Vec2fArray.FromNumpy(surface.uv.astype(np.float32)))
        if surface.uv_faces is not None:
            st.SetIndices(_integers(surface.uv_faces))
    if surface.colors is not None:
        colors = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
        colors.Set(_vectors(linear_colors(surface.colors)))
    return mesh


def _bind(stage: Usd.Stage, mesh: UsdGeom.Mesh, rig: Rig) -> None:
    """All vertices on the one joint, whose rest is the origin."""
    skeleton = UsdSkel.Skeleton.Define(stage, ROOT.AppendChild("skeleton"))
    skeleton.CreateJointsAttr([JOINT])
    still = Vt.Matrix4dArray([Gf.Matrix4d(1.0)])
    skeleton.CreateBindTransformsAttr(still)
    skeleton.CreateRestTransformsAttr(still)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    n = len(rig.neutral.vertices)
    binding.CreateJointIndicesPrimvar(False, 1).Set(Vt.IntArray(n, 0))
    binding.CreateJointWeightsPrimvar(False, 1).Set(Vt.FloatArray(n, 1.0))


def _shapes(stage: Usd.Stage, mesh: UsdGeom.Mesh, rig: Rig, normals: np.ndarray) -> None:
    targets = []
    for k, prim_name in enumerate(prim_names(rig.names)):
        shape = UsdSkel.BlendShape.Define(stage, mesh.GetPath().AppendChild(prim_name))
        turns = normal_offsets(rig, k, normals)
        moved = np.abs(rig.deltas[k]).max(axis=1) >= _NOTHING_MM
        rows = np.flatnonzero(moved | turns.any(axis=1))
        rows = rows if len(rows) else np.zeros(1, np.int64)  # Blender drops shapes without offsets, name and all
        shape.CreateOffsetsAttr(_vectors(rig.deltas[k][rows] * MM))
        shape.CreateNormalOffsetsAttr(_vectors(turns[rows]))
        shape.CreatePointIndicesAttr(_integers(rows))
        if prim_name != rig.names[k]:
            shape.GetPrim().SetDisplayName(rig.names[k])
        targets.append(shape.GetPath())
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    binding.CreateBlendShapesAttr(list(rig.names))
    binding.CreateBlendShapeTargetsRel().SetTargets(targets)


def _animate(stage: Usd.Stage, played: Performance) -> None:
    rate, last = played.rate, len(played) - 1
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(last)
    motion = UsdSkel.Animation.Define(stage, ROOT.AppendChild("performance"))
    skeleton = stage.GetPrimAtPath(ROOT.AppendChild("skeleton"))
    UsdSkel.BindingAPI(skeleton).CreateAnimationSourceRel().SetTargets([motion.GetPath()])
    motion.CreateJointsAttr([JOINT])
    motion.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)]))
    motion.CreateBlendShapesAttr(list(played.rig.names))
    weights, places = motion.CreateBlendShapeWeightsAttr(), motion.CreateTranslationsAttr()
    turns = motion.CreateRotationsAttr()
    pose = played.T_world_face
    x, y, z, w = quaternions_from_rotations(pose.rotation).T.tolist()
    moved = (pose.translation * MM).astype(np.float32)
    for t in range(len(played)):
        weights.Set(Vt.FloatArray.FromNumpy(played.weights[t].astype(np.float32)), t)
        places.Set(_vectors(moved[t : t + 1]), t)
        turns.Set(Vt.QuatfArray([Gf.Quatf(w[t], x[t], y[t], z[t])]), t)
    motion.GetPrim().SetCustomDataByKey(RATE, float(rate))
    untracked = np.flatnonzero(~played.tracked)
    motion.GetPrim().SetCustomDataByKey(UNTRACKED, _integers(untracked))


def _extent(rig: Rig, played: Performance | None) -> Vt.Vec3fArray:
    """A box, metres, that holds the face in every shape and frame."""
    reach = np.linalg.norm(rig.deltas, axis=2).max(initial=0.0)
    low, high = rig.neutral.vertices.min(axis=0) - reach, rig.neutral.vertices.max(axis=0) + reach
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1), indexing="ij"), axis=-1).reshape(-1, 3)
    if played is not None:
        corners = played.T_world_face.apply(np.broadcast_to(corners, (len(played), 8, 3))).reshape(-1, 3)
    return _vectors(np.stack([corners.min(axis=0), corners.max(axis=0)]) * MM)


def _vectors(values: np.ndarray) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32).reshape(-1, 3))


def _integers(values: np.ndarray) -> Vt.IntArray:
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(values, np.int32).ravel())
