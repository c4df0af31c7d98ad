"""Analytic scenes for tests of active light: a ball before a stereo pair and a projector."""

import numpy as np

from mien.camera import Camera
from mien.light.decode_sinusoids import Decoded
from mien.light.light_rig import LightRig, RigView
from mien.light.triangulate import pixel_rays
from mien.transforms import Transform, rotation_from_vector

CENTRE, RADIUS = np.array([0.0, 0.0, 600.0]), 80.0


def view(name, x, y=0.0, focal=600.0, size=(160, 200), turn=None):
    """A view at (x, y, 0) of rig space that looks at the ball, or along z turned by a vector."""
    eye = np.array([x, y, 0.0])
    vector = np.array([-y / 600, x / 600, 0.0]) if turn is None else np.array(turn, float)
    rotation = rotation_from_vector(vector)
    return RigView(name, Camera(focal, focal, size[0] / 2, size[1] / 2, *size), Transform(rotation, -rotation @ eye))


def rig():
    return LightRig(
        (view("left", 0.0, turn=(0, 0, 0)), view("right", 160.0)), view("projector", 80.0, -50.0, 500.0, (256, 256))
    )


def ball_depth(seen):
    """Depth and outward normals of the ball, camera space, NaN beside it."""
    rays = pixel_rays(seen.camera)
    centre = seen.T_view_rig.apply(CENTRE[None])[0]
    a, b, c = (rays**2).sum(-1), rays @ centre, centre @ centre - RADIUS**2
    root = b**2 - a * c
    z = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.nan)
    return z, (rays * z[..., None] - centre) / RADIUS


def ball_columns(seen, projector, sigma=0.05):
    """What a perfect decoder finds."""
    z, _ = ball_depth(seen)
    points = (pixel_rays(seen.camera) * z[..., None]).reshape(-1, 3)
    local = (projector.T_view_rig @ seen.T_view_rig.inverse()).apply(points)
    pixel = projector.distorted(projector.camera.project(local))[:, 0].reshape(z.shape)
    return Decoded(pixel, np.where(np.isfinite(pixel), sigma, np.nan))
