"""Many depth frames of a calm face become one scan: projective ICP and a distance volume (Li et al. 2013, sec. 3)."""

from collections.abc import Sequence
from dataclasses import dataclass

import igl
import numpy as np
from jaxtyping import Float32

from ..._kernels import tsdf
from ...camera import Camera
from ...depth import RGBDFrame, median
from ...errors import BadInput
from ...mesh import Mesh
from ...progress import SILENT, Progress
from ...transforms import Transform
from ..preprocess_frame import FrameObservation
from ..rigid import RigidConfig, align

SEEN_OFTEN = 3.0
"""Frames that must have seen a voxel for its surface to be kept, where there are twice as many."""
FEWEST_VERTICES = 500
"""A volume's surface of fewer vertices is no face."""


@dataclass(frozen=True)
class AggregateConfig:
    """The volume, in the space of the roughly placed face."""

    low: tuple[float, float, float] = (-90.0, -115.0, -10.0)
    """Its lower corner, mm."""
    high: tuple[float, float, float] = (90.0, 105.0, 130.0)
    """Its upper corner, mm."""
    voxel: float = 1.5
    """Side of a voxel, mm."""
    truncation: float = 6.0
    """Distances are kept up to this, mm."""
    every: int = 10
    """After so many frames the model that frames are aligned to is drawn from the volume again."""
    enough: float = 2.0
    """A frame that cannot be aligned better than this, mm, is left out."""
    rigid: RigidConfig = RigidConfig(enough=0.0, iterations=8, robust_scale_mm=2.0, reach=15.0)
    """Each frame onto the scan so far: every step is made, and what moves by itself hardly counts."""
    most_weight: float = 200.0
    """Frames after which a voxel's average forgets the oldest."""


class Volume:
    """A truncated signed distance volume."""

    def __init__(self, config: AggregateConfig):
        self.config = config
        self.origin = np.array(config.low, float)
        shape = tuple(np.ceil((np.array(config.high) - self.origin) / config.voxel).astype(int) + 1)
        self.distance = np.ones(shape, np.float32)
        self.weight = np.zeros(shape, np.float32)

    def integrate(self, depth: Float32[np.ndarray, "h w"], camera: Camera, T_camera_volume: Transform) -> None:
        """Average in one depth image (mm)."""
        c = self.config
        tsdf.integrate(
            self.distance, self.weight, self.origin, c.voxel, T_camera_volume.rotation, T_camera_volume.translation,
            depth, np.array([camera.fx, camera.fy, camera.cx, camera.cy]), c.truncation, c.most_weight,
        )  # fmt: skip

    def surface(self, least: float = 1.0) -> Mesh:
        """The surface where voxels were seen `least` times or more, mm. Orientation: outwards."""
        shape = self.distance.shape
        values = np.where(self.weight >= least, self.distance, 1.0)
        grid = np.stack(np.meshgrid(*(np.arange(n, dtype=float) for n in shape), indexing="ij"), -1)
        flat = (values.ravel(order="F").astype(np.float64), grid.reshape(-1, 3, order="F"))
        found = igl.marching_cubes(*flat, *shape, 0.0)
        vertices, faces = np.asarray(found[0]), np.asarray(found[1])
        lower = np.clip(np.floor(vertices).astype(int), 0, np.array(shape) - 2)
        corners = [np.array([a, b, c]) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
        seen = np.min([self.weight[tuple((lower + corner).T)] for corner in corners], axis=0) >= least
        faces = faces[seen[faces].all(1)]
        used, again = np.unique(faces, return_inverse=True)
        return _outwards(Mesh(self.origin + vertices[used] * self.config.voxel, again.reshape(-1, 3)), self)


def _outwards(mesh: Mesh, volume: Volume) -> Mesh:
    """Turn the triangles round if their normals point to where distances fall."""
    if not len(mesh.faces):
        return mesh
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    ahead = (corners.mean(1) + normals * volume.config.voxel - volume.origin) / volume.config.voxel
    index = np.clip(np.round(ahead).astype(int), 0, np.array(volume.distance.shape) - 1)
    outward = volume.distance[tuple(index.T)].mean() > 0
    return mesh if outward else Mesh(mesh.vertices, mesh.faces[:, ::-1].copy())


@dataclass(frozen=True)
class Aggregate:
    """The scan and where the head was."""

    scan: Mesh
    """In the space of `T_camera_face` of the first frame, mm."""
    T_camera_face: tuple[Transform | None, ...]
    """One a frame; None where the frame could not be aligned."""
    frame_distance: float
    """Mean distance of the frames from the scan after alignment, mm."""


def aggregate(
    frames: Sequence[RGBDFrame],
    camera: Camera,
    T_camera_face: Transform,
    config: AggregateConfig = AggregateConfig(),
    progress: Progress = SILENT,
) -> Aggregate:
    """Align every frame to the scan so far and average it in; `T_camera_face` places the first, roughly.

    Raises:
        BadInput: no depth in the volume, or fewer than half of the frames could be aligned.
    """
    volume, poses, errors = Volume(config), [], []
    model = None
    for i, frame in enumerate(frames):
        depth = median(_depth_of(frame))
        if model is not None:
            found = _settle(model, T_camera_face, FrameObservation(depth, camera), config.rigid)
            poses.append(found.T_camera_face if found.error < config.enough else None)
            errors.append(found.error)
        else:
            poses.append(T_camera_face)
        if poses[-1] is not None:
            T_camera_face = poses[-1]
            volume.integrate(depth, camera, T_camera_face)
        if i % config.every == 0 or model is None:
            model = _model(volume)
        progress.update("aggregating depth", i + 1, len(frames))
    kept = sum(pose is not None for pose in poses)
    if kept < 0.5 * len(frames):
        raise BadInput(
            f"only {kept} of {len(frames)} frames hold still enough to be merged; hold a neutral face for a second or "
            "two, and name its frames with --frames"
        )
    least = min(SEEN_OFTEN, kept / 2)
    return Aggregate(volume.surface(least), tuple(poses), float(np.mean(errors)) if errors else 0.0)


def _depth_of(frame: RGBDFrame) -> Float32[np.ndarray, "h w"]:
    if frame.depth is None:
        raise BadInput(f"the frame at {frame.time:.3f} s has no depth; a rig is made from an RGB-D take")
    return frame.depth


def _model(volume: Volume) -> Mesh:
    mesh = volume.surface()
    if len(mesh.vertices) < FEWEST_VERTICES:
        raise BadInput("there is no depth where the landmarks see the face; check that depth is registered to colour")
    return mesh


def _settle(model: Mesh, T_camera_face: Transform, observation: FrameObservation, rigid: RigidConfig):
    vertices = model.vertices.astype(np.float32)
    share = np.full(len(vertices), 1 / len(vertices), np.float32)
    return align(vertices, model.faces.astype(np.int32), share, T_camera_face, observation, rigid)
