"""Cameras, projector and their places: what calibration gives and every later step needs."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy import ndimage

from ..camera import Camera
from ..errors import BadInput
from ..files import existing, whole
from ..rgbd.intrinsics import intrinsics_of, matrix_values
from ..transforms import Transform

UNDISTORT_ROUNDS = 20
"""Fixed-point rounds: more than any lens of a face rig needs for 1e-9 of a focal length."""


@dataclass(frozen=True)
class RigView:
    """One camera, or the projector, which is a camera that shines."""

    name: str
    camera: Camera
    T_view_rig: Transform
    """From rig space (mm; by default the first camera's) to this view's."""
    distortion: tuple[float, ...] = (0.0,) * 5
    """k1, k2, p1, p2, k3 of Brown's lens model (OpenCV's order)."""
    rms_px: float = 0.0
    """Reprojection error of its calibration."""

    def undistorted(self, pixels: Float[np.ndarray, "*n 2"]) -> Float[np.ndarray, "*n 2"]:
        """Pixels as seen -> pixels of the pinhole camera."""
        seen = self.camera.rays(pixels)[..., :2]
        ideal = seen
        if any(self.distortion):
            for _ in range(UNDISTORT_ROUNDS):
                ideal = ideal + (seen - brown_distortion(ideal, self.distortion))
        return self.camera.project(np.concatenate([ideal, np.ones_like(ideal[..., :1])], -1))

    def distorted(self, pixels: Float[np.ndarray, "*n 2"]) -> Float[np.ndarray, "*n 2"]:
        """Pixels of the pinhole camera -> pixels as seen."""
        ideal = self.camera.rays(pixels)[..., :2]
        seen = brown_distortion(ideal, self.distortion)
        return self.camera.project(np.concatenate([seen, np.ones_like(seen[..., :1])], -1))

    def straightened(self, images: Float[np.ndarray, "*n h w"]) -> Float[np.ndarray, "*n h w"]:
        """Pictures as the pinhole camera would take them."""
        if not any(self.distortion):
            return images
        x, y = np.meshgrid(np.arange(self.camera.width), np.arange(self.camera.height))
        source = self.distorted(np.stack([x, y], -1).astype(float))
        where = [source[..., 1], source[..., 0]]
        flat = images.reshape(-1, *images.shape[-2:])
        return np.stack([ndimage.map_coordinates(image, where, order=1) for image in flat]).reshape(images.shape)


def brown_distortion(points: Float[np.ndarray, "*n 2"], distortion: tuple[float, ...]) -> Float[np.ndarray, "*n 2"]:
    """Brown's lens model on the plane z = 1."""
    k1, k2, p1, p2, k3 = distortion
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([bent_x, bent_y], -1)


@dataclass(frozen=True)
class LightRig:
    """Everything that took and lit the pictures."""

    cameras: tuple[RigView, ...]
    """The first is the one that scans are written in the frame of."""
    projector: RigView | None = None
    R_rig_lamps: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
    """From the lamps' axes (x, y, z of the gradients) to rig space; by default y up and z towards the cameras."""
    gamma: float = 1.0
    """Stored value = linear value ^ (1 / gamma). 1: linear pictures."""

    def R_view_lamps(self, view: RigView) -> Float[np.ndarray, "3 3"]:
        """From the lamps' axes to a camera's space."""
        return view.T_view_rig.rotation @ np.array(self.R_rig_lamps)

    def camera(self, name: str) -> RigView:
        """By name.

        Raises:
            BadInput: no such camera.
        """
        for view in self.cameras:
            if view.name == name:
                return view
        raise BadInput(f"calibration: no camera {name!r}; it has {', '.join(view.name for view in self.cameras)}")


def write_rig(path: str | Path, rig: LightRig) -> None:
    """As JSON: a camera is Open3D's PinholeCameraIntrinsic with its pose, distortion and error beside it."""
    told: dict[str, Any] = {"cameras": [_view(view) for view in rig.cameras], "gamma": rig.gamma}
    told["R_rig_lamps"] = rig.R_rig_lamps
    if rig.projector is not None:
        told["projector"] = _view(rig.projector)
    with whole(path) as temporary:
        temporary.write_text(json.dumps(told, indent=1))


def read_rig(path: str | Path) -> LightRig:
    """A calibration that `write_rig` has left.

    Raises:
        BadInput: no such file, or not a calibration.
    """
    path = existing(path)
    try:
        told = json.loads(path.read_text())
        cameras = tuple(_read_view(view) for view in told["cameras"])
        projector = _read_view(told["projector"]) if told.get("projector") else None
        lamps = np.array(told.get("R_rig_lamps", LightRig.R_rig_lamps), float)
        gamma = float(told.get("gamma", 1.0))
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        raise BadInput(f"{path}: no calibration ({error}); make one by `mien decode POSES/ --board 9x7x75`") from None
    if not cameras or lamps.shape != (3, 3) or not 0.2 < gamma < 5:
        raise BadInput(f"{path}: expected cameras, 3 x 3 R_rig_lamps and a gamma of 0.2 to 5")
    return LightRig(cameras, projector, tuple(tuple(row) for row in lamps.tolist()), gamma)


def _view(view: RigView) -> dict[str, Any]:
    return {
        "name": view.name,
        **intrinsics_of(view.camera),
        "distortion": list(view.distortion),
        "R_view_rig": np.asarray(view.T_view_rig.rotation).tolist(),
        "t_view_rig": np.asarray(view.T_view_rig.translation).tolist(),
        "rms_px": view.rms_px,
    }


def _read_view(told: dict[str, Any]) -> RigView:
    R, t = np.array(told["R_view_rig"], float), np.array(told["t_view_rig"], float)
    if R.shape != (3, 3) or t.shape != (3,) or not np.isfinite([*R.ravel(), *t]).all():
        raise ValueError("expected R_view_rig of 3 x 3 numbers and t_view_rig of 3")
    camera = Camera(*matrix_values(told["intrinsic_matrix"]), int(told["width"]), int(told["height"]))
    distortion = tuple(float(k) for k in told.get("distortion", (0.0,) * 5))
    if len(distortion) != 5:
        raise ValueError(f"expected 5 coefficients of distortion, got {len(distortion)}")
    return RigView(str(told["name"]), camera, Transform(R, t), distortion, float(told.get("rms_px", 0.0)))
