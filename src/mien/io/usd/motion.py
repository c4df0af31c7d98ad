"""What animates a face on a USD stage: weights of blend shapes, and the motion of its head."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from pxr import Gf, Usd, UsdGeom, UsdSkel

from ...errors import BadInput
from ...transforms import Transform
from ..gltf.animation import even_times

RATE, UNTRACKED = "mien:rate", "mien:untracked"
"""Keys of the animation's custom data: frames a second, and frames that hold the last value."""
_SIZE = 0.01
"""A head whose size changes by more than this share is no rigid one."""
_WHOLE = 1e-3
"""Times this near to whole time codes are frames of the stage."""


@dataclass(frozen=True)
class FaceMotion:
    """An animation at even times."""

    names: tuple[str, ...]
    """The shapes, as the animation calls them."""
    weights: Float[np.ndarray, "frames names"]
    T_world_face: Transform
    """Rest -> frame, in the stage turned to +Y up, millimetres."""
    rate: float
    untracked: tuple[int, ...]


def read_motion(path: Path, stage: Usd.Stage, mesh: UsdGeom.Mesh, to_mm: Float[np.ndarray, "4 4"]) -> FaceMotion:
    """The animation of a mesh.

    Raises:
        BadInput: nothing animates its blend shapes, or its head changes size.
    """
    weights = weight_attribute(mesh)
    if weights is None:
        raise BadInput(f"{path}: nothing animates its blend shapes, so it is a rig, not a performance")
    animation = weights.GetPrim()
    names = UsdSkel.Animation(animation).GetBlendShapesAttr().Get()
    times = np.array(weights.GetTimeSamples())
    codes = stage.GetTimeCodesPerSecond()
    stated = animation.GetCustomDataByKey(RATE)
    whole = bool(np.abs(times - times.round()).max() < _WHOLE)
    even, rate = even_times(times / codes, float(stated) if stated else codes if whole else None)
    at = (even * codes).tolist()
    rows = [np.array(weights.Get(Usd.TimeCode(code)), np.float64) for code in at]
    untracked = animation.GetCustomDataByKey(UNTRACKED)
    return FaceMotion(
        names=tuple(str(name) for name in names),
        weights=np.stack(rows).reshape(len(at), len(names)),
        T_world_face=_head_motion(path, mesh, at, to_mm),
        rate=rate,
        untracked=tuple(int(frame) for frame in untracked) if untracked is not None else (),
    )


def matrix(of: Gf.Matrix4d) -> Float[np.ndarray, "4 4"]:
    """USD's matrix, which multiplies rows, as one that multiplies columns."""
    return np.array(of, np.float64).T


def weight_attribute(mesh: UsdGeom.Mesh) -> Usd.Attribute | None:
    """The weights that animate a mesh's blend shapes: by its own animation, else by its skeleton's; None without."""
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    skeleton = binding.GetInheritedSkeleton()
    holders = [binding] + ([UsdSkel.BindingAPI(skeleton.GetPrim())] if skeleton else [])
    for holder in holders:
        source = holder.GetInheritedAnimationSource()
        if source and source.IsA(UsdSkel.Animation):
            weights = UsdSkel.Animation(source).GetBlendShapeWeightsAttr()
            return weights if weights.GetTimeSamples() else None
    return None


def _head_motion(path: Path, mesh: UsdGeom.Mesh, codes: list[float], to_mm: Float[np.ndarray, "4 4"]) -> Transform:
    poses = np.stack([to_mm @ each for each in _poses(mesh, codes)])
    motion = poses @ np.linalg.inv(to_mm @ _rest(mesh))
    size = np.cbrt(np.linalg.det(motion[:, :3, :3]))
    if np.abs(size - 1).max() > _SIZE:
        raise BadInput(f"{path}: its animation changes the head's size (to {size.max():.3g}); bake the scale in")
    u, _, vt = np.linalg.svd(motion[:, :3, :3])
    return Transform(u @ vt, motion[:, :3, 3])


def _rest(mesh: UsdGeom.Mesh) -> Float[np.ndarray, "4 4"]:
    """Skinning space -> stage, unposed."""
    skeleton, _ = _skin(mesh)
    place = UsdGeom.Xformable((skeleton or mesh).GetPrim())
    return matrix(place.ComputeLocalToWorldTransform(Usd.TimeCode.EarliestTime()))


def _poses(mesh: UsdGeom.Mesh, codes: list[float]) -> list[np.ndarray]:
    """Skinning space -> stage, frame by frame: the joint that bears the face, or the mesh's own transform."""
    skeleton, joint = _skin(mesh)
    if skeleton is None:
        return [matrix(mesh.ComputeLocalToWorldTransform(Usd.TimeCode(code))) for code in codes]
    query = UsdSkel.Cache().GetSkelQuery(skeleton)
    place = UsdGeom.Xformable(skeleton.GetPrim())
    poses = []
    for code in codes:
        skinned = query.ComputeSkinningTransforms(Usd.TimeCode(code))
        world = matrix(place.ComputeLocalToWorldTransform(Usd.TimeCode(code)))
        poses.append(world @ matrix(skinned[joint]))
    return poses


def _skin(mesh: UsdGeom.Mesh) -> tuple[UsdSkel.Skeleton | None, int]:
    """The skeleton of a skinned mesh, and the joint with most of its weight."""
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    skeleton = binding.GetInheritedSkeleton()
    indices, weights = binding.GetJointIndicesAttr().Get(), binding.GetJointWeightsAttr().Get()
    if not skeleton or not indices or not weights or len(indices) != len(weights):
        return None, 0
    total = np.bincount(np.array(indices, np.int64), np.array(weights, np.float64))
    joint = int(np.argmax(total))
    own = binding.GetJointsAttr().Get()
    order = [str(name) for name in skeleton.GetJointsAttr().Get()]
    return skeleton, order.index(str(own[joint])) if own else joint
