"""A dotted ball scanned in any pose, for tests of clips."""

import numpy as np

import light_scene
from mien.light.disk.light_scan import LightScan
from mien.light.triangulate import pixel_rays
from mien.transforms import Transform, rotation_from_vector

VIEW = light_scene.rig().cameras[0]
RADIUS_MM = 3.0
"""Of a dot."""


def dots(count=24, spread=0.8):
    """Directions from the ball's middle to its dots, evenly over the side that the camera sees."""
    turn = np.arange(count) * np.pi * (3 - np.sqrt(5))
    tilt = spread * np.sqrt((np.arange(count) + 0.5) / count)
    return np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), -np.cos(tilt)], 1)


def pose(turn=(0, 0, 0), move=(0, 0, 0)):
    """The ball turned about its middle and moved."""
    rotation, middle = rotation_from_vector(np.array(turn, float)), light_scene.CENTRE
    return Transform(rotation, middle + np.array(move, float) - rotation @ middle)


def scan(T=None, ripple=0.0, dark=0.1):
    """What a perfect scanner sees: unit albedo, dots, and ripples of some mm that go with the skin."""
    T = T or pose()
    rays = pixel_rays(VIEW.camera)
    centre = T.apply(light_scene.CENTRE[None])[0]
    local = rays @ T.rotation
    middle = T.rotation.T @ centre
    b, a = local @ middle, (local**2).sum(-1)
    radius = np.full(b.shape, light_scene.RADIUS)
    for _ in range(4):
        root = b**2 - a * (middle @ middle - radius**2)
        z = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.nan)
        outward = (local * z[..., None] - middle) / radius[..., None]
        radius = light_scene.RADIUS + ripple * np.sin(70 * outward[..., 0]) * np.sin(60 * outward[..., 1])
    nearest = np.nanmax(np.nan_to_num(outward) @ dots().T, axis=-1)
    albedo = np.where(np.isfinite(z), np.where(np.arccos(np.clip(nearest, -1, 1)) * 80 < RADIUS_MM, dark, 1.0), np.nan)
    normals = np.where(np.isfinite(z)[..., None], outward @ T.rotation.T, np.nan)
    sound = np.isfinite(z).astype(float)
    return LightScan(rays * z[..., None], normals, albedo, sound, 0.05 * sound)


def places(T=None):
    """True places of the dots, rig space, mm."""
    return (T or pose()).apply(light_scene.CENTRE + light_scene.RADIUS * dots())
