"""A face out of a USD stage: the mesh with the most blend shapes, and what animates it."""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float32, Int
from pxr import Gf, Tf, Usd, UsdGeom, UsdSkel, UsdUtils

from ...errors import BadInput
from ...files import existing
from ...mesh import Mesh
from ...rig import Performance, Rig
from ...rig.unit_weights import joined
from ..meshes.polygons import fan
from .displacement import is_displaced, read_maps
from .material import read_texture, srgb_colors
from .motion import FaceMotion, matrix, read_motion, weight_attribute

_MM_IN_METRE = 1000.0
_DAMAGE = (
    Tf.ErrorException,
    LookupError,
    ValueError,
    ArithmeticError,
    AttributeError,
    TypeError,
    RuntimeError,
    MemoryError,
)
"""What USD and numpy raise on a broken file."""
_LONGEST_FAULT = 120
"""Characters of USD's own words in a message."""


@dataclass(frozen=True)
class OpenFace:
    """A stage and its face."""

    path: Path
    stage: Usd.Stage
    mesh: UsdGeom.Mesh
    tell: Callable[[str], None]

    def rig(self) -> Rig:
        """The mesh and its shapes, in face space as far as the file is, millimetres."""
        with told(self.path):
            rig = self._rig()
        return joined(rig, np.zeros((0, len(rig.names))))[0]

    def is_animated(self) -> bool:
        """Whether something moves the blend shapes."""
        with told(self.path):
            return weight_attribute(self.mesh) is not None

    def performance(self) -> Performance:
        """The rig and its animation."""
        with told(self.path):
            rig = self._rig()
            motion = read_motion(self.path, self.stage, self.mesh, self._to_mm())
            weights = _in_order(self.path, motion, self._tokens())
        if not np.isfinite(weights).all():
            raise BadInput(f"{self.path}: holds weights that are not finite; export it again")
        rig, weights = joined(rig, weights)
        tracked = np.ones(len(weights), bool)
        tracked[[frame for frame in motion.untracked if 0 <= frame < len(weights)]] = False
        return Performance(rig, weights, motion.T_world_face, motion.rate, tracked)

    def heights(self) -> Iterator[Float32[np.ndarray, "h w"]]:
        """Its displacement maps, mm."""
        with told(self.path):
            yield from read_maps(self.path, self.mesh, UsdGeom.GetStageMetersPerUnit(self.stage) * _MM_IN_METRE)

    def _tokens(self) -> list[str]:
        tokens = UsdSkel.BindingAPI(self.mesh.GetPrim()).GetBlendShapesAttr().Get()
        return [str(token) for token in tokens or []]

    def _to_mm(self) -> Float[np.ndarray, "4 4"]:
        """Stage -> +Y up, millimetres."""
        out = np.eye(4)
        if UsdGeom.GetStageUpAxis(self.stage) == UsdGeom.Tokens.z:
            out[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
        return out * [[*[UsdGeom.GetStageMetersPerUnit(self.stage) * _MM_IN_METRE] * 3, 1]]

    def _rig(self) -> Rig:
        placed = self._to_mm() @ unposed_matrix(self.mesh)
        points = np.array(self.mesh.GetPointsAttr().Get(Usd.TimeCode.EarliestTime()), np.float64).reshape(-1, 3)
        vertices = points @ placed[:3, :3].T + placed[:3, 3]
        if len(vertices) == 0 or not np.isfinite(vertices).all():
            raise BadInput(f"{self.path}: its mesh has no vertices or some that are not finite; export it again")
        corners, faces = _triangles(self.mesh)
        if np.linalg.det(placed[:3, :3]) < 0:
            corners, faces = corners[:, ::-1], faces[:, ::-1]
        names, deltas = self._shapes(len(vertices))
        uv, uv_faces = _texture_coordinates(self.mesh, corners, faces, len(vertices))
        surface = Mesh(vertices, faces, uv, uv_faces, srgb_colors(self.mesh, len(vertices)))
        if is_displaced(self.mesh):
            self.tell(f"{self.path}: displacement maps are left out of what is read")
        return Rig(surface, deltas @ placed[:3, :3].T, names, read_texture(self.mesh))

    def _shapes(self, n: int) -> tuple[tuple[str, ...], Float[np.ndarray, "shapes n 3"]]:
        """Names and displacements in the mesh's own space."""
        names = self._tokens()
        targets = UsdSkel.BindingAPI(self.mesh.GetPrim()).GetBlendShapeTargetsRel().GetTargets()
        if len(names) != len(targets) or len(set(names)) < len(names):
            raise BadInput(f"{self.path}: {len(targets)} blend shapes by {len(set(names))} names; export it again")
        deltas = np.zeros((len(names), n, 3))
        between = []
        for k, target in enumerate(targets):
            shape = UsdSkel.BlendShape(self.stage.GetPrimAtPath(target))
            deltas[k] = _displacement(self.path, names[k], shape, n)
            between += [names[k]] if shape.GetInbetweens() else []
        if between:
            self.tell(f"{self.path}: inbetweens are left out, of {len(between)} shapes ({between[0]} the first)")
        return tuple(names), deltas


def open_face(path: Path, tell: Callable[[str], None]) -> OpenFace:
    """Open a file and find its face.

    Raises:
        BadInput: missing, damaged, or no mesh has blend shapes.
    """
    path = existing(path)
    with told(path):
        stage = Usd.Stage.Open(str(path))
        best, most = None, 0
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            if prim.IsA(UsdGeom.Mesh):
                count = len(UsdSkel.BindingAPI(prim).GetBlendShapeTargetsRel().GetTargets())
                best, most = (prim, count) if count > most else (best, most)
    if best is None:
        raise BadInput(f"{path}: has no blend shapes, so it is no rig; export blend shapes along")
    return OpenFace(path, stage, UsdGeom.Mesh(best), tell)


@contextmanager
def told(path: Path) -> Iterator[None]:
    """Turn what goes wrong in a broken file into one BadInput line, and keep USD's own warnings to itself."""
    quiet = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        with np.errstate(all="ignore"):
            yield
    except BadInput:
        raise
    except _DAMAGE as error:
        what = _first_fault(error)
        raise BadInput(f"{path}: is damaged or no valid USD ({what}); export it again") from error
    finally:
        del quiet


def _first_fault(error: Exception) -> str:
    """What USD's message quotes first, without the places in USD's own code; it may quote bytes that are no text."""
    try:
        message = str(error)
    except UnicodeDecodeError:
        return "bytes that are no text"
    quoted = re.search(r": '(?:[^']*?\.usd\w?:)?([^']*)'", message)
    return " ".join((quoted.group(1) if quoted else message).split())[:_LONGEST_FAULT]


def unposed_matrix(mesh: UsdGeom.Mesh) -> Float[np.ndarray, "4 4"]:
    """Points of the mesh -> stage, unposed: a skinned mesh stands where its skeleton's bind pose has it."""
    time = Usd.TimeCode.EarliestTime()
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    skeleton = binding.GetInheritedSkeleton()
    if not skeleton or not binding.GetJointIndicesAttr().HasAuthoredValue():
        return matrix(mesh.ComputeLocalToWorldTransform(time))
    bind = binding.GetGeomBindTransformAttr().Get()
    placed = UsdGeom.Xformable(skeleton.GetPrim()).ComputeLocalToWorldTransform(time)
    return matrix(placed) @ matrix(bind if bind is not None else Gf.Matrix4d(1.0))


def _triangles(mesh: UsdGeom.Mesh) -> tuple[Int[np.ndarray, "m 3"], Int[np.ndarray, "m 3"]]:
    """Corners (places in the file's list of corners) and vertices of each triangle, outside out."""
    time = Usd.TimeCode.EarliestTime()
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(time), np.int64)
    indices = np.array(mesh.GetFaceVertexIndicesAttr().Get(time), np.int64)
    holes = mesh.GetHoleIndicesAttr().Get(time)
    corners = fan(counts)
    if holes:
        of_face = np.repeat(np.arange(len(counts)), np.maximum(counts - 2, 0))
        corners = corners[~np.isin(of_face, np.array(holes))]
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        corners = corners[:, ::-1]
    return corners, indices[corners]


def _texture_coordinates(
    mesh: UsdGeom.Mesh, corners: np.ndarray, faces: np.ndarray, n: int
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """The mesh's texture coordinates as `Mesh` has them: by vertex, or by corner."""
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    if not st:
        every = UsdGeom.PrimvarsAPI(mesh).GetPrimvarsWithValues()
        st = next((each for each in every if each.GetTypeName().role == "TextureCoordinate"), None)
    values = st.Get(Usd.TimeCode.EarliestTime()) if st else None
    if st is None or not values:
        return None, None
    uv = np.array(values, np.float64).reshape(len(values), -1)[:, :2]
    indices = st.GetIndices(Usd.TimeCode.EarliestTime())
    by_corner = st.GetInterpolation() == UsdGeom.Tokens.faceVarying
    if not by_corner and not indices and len(uv) == n:
        return uv, None
    order = np.array(indices, np.int64) if indices else np.arange(len(uv))
    return uv, order[corners if by_corner else faces]


def _displacement(path: Path, name: str, shape: UsdSkel.BlendShape, n: int) -> Float[np.ndarray, "n 3"]:
    offsets = np.array(shape.GetOffsetsAttr().Get() or [], np.float64).reshape(-1, 3)
    rows = shape.GetPointIndicesAttr().Get()
    out = np.zeros((n, 3))
    at = np.arange(n) if rows is None else np.array(rows, np.int64)
    if len(at) != len(offsets) or (len(at) and (at.min() < 0 or at.max() >= n)):
        raise BadInput(f"{path}: blend shape {name} has offsets for other vertices than the mesh's {n}; export again")
    out[at] = offsets
    if not np.isfinite(out).all():
        raise BadInput(f"{path}: blend shape {name} is not finite; export again")
    return out


def _in_order(path: Path, motion: FaceMotion, names: list[str]) -> Float[np.ndarray, "frames shapes"]:
    """The animation's weights in the mesh's order; shapes that it leaves out stay at 0."""
    column = {name: k for k, name in enumerate(motion.names)}
    if not any(name in column for name in names):
        raise BadInput(f"{path}: its animation moves none of its blend shapes; export it again")
    weights = np.zeros((len(motion.weights), len(names)))
    for k, name in enumerate(names):
        if name in column:
            weights[:, k] = motion.weights[:, column[name]]
    return weights
