"""`shade` in numpy, function by function."""

import numpy as np
from scipy.ndimage import map_coordinates

from .shade import SHOULDER, WET


def interpolate(values, corners, weights):
    """As `mien._kernels.shade.interpolate`."""
    return np.einsum("sc,scd->sd", weights, values[corners]).astype(np.float32)


def bilinear(texture, curve, uv):
    """As `mien._kernels.shade.bilinear`."""
    height, width, _ = texture.shape
    places = np.stack([(1 - uv[:, 1].astype(float)) * height - 0.5, uv[:, 0].astype(float) * width - 0.5])
    linear = curve[texture].astype(float)
    channels = [map_coordinates(linear[..., c], places, order=1, mode="grid-wrap") for c in range(3)]
    return np.stack(channels, 1).astype(np.float32)


def lift(points, normals, corners, weights):
    """As `mien._kernels.shade.lift`."""
    flat = np.einsum("sc,scd->sd", weights, points[corners])
    below = np.einsum("scd,scd->sc", flat[:, None] - points[corners], normals[corners])
    return flat - np.einsum("sc,sc,scd->sd", weights, np.minimum(below, 0), normals[corners])


def light(normals, points, albedo, open_sky, shadow, wet, lamps, ambient, skin):
    """As `mien._kernels.shade.light`."""
    n, v, clear = unit(normals), unit(-points), open_sky[:, None]
    wet = wet[:, None]
    wrap, f0, roughness = skin[:3], skin[3] + wet * (WET[0] - skin[3]), skin[4] + wet * (WET[1] - skin[4])
    facing = np.maximum((n * v).sum(1), 0)[:, None]
    sky = 0.5 - 0.5 * n[:, 1:2]
    smooth = np.minimum(4 * albedo.mean(1, keepdims=True) + wet, 1)
    sheen = (f0 + (1 - f0) * (1 - facing) ** 5) * 0.35 * clear**2 * smooth
    around = sky * ambient[0] + (1 - sky) * ambient[1]
    out = around * (albedo * clear / (1 - albedo * (1 - clear) * 0.8) + sheen)
    for index, lamp in enumerate(lamps):
        cosine = (n @ lamp[:3])[:, None]
        through, polish = 0.4 * clear + 0.6 * clear**2, smooth
        if index == 0:
            fade = np.clip(cosine / 0.25, 0, 1)
            fade = fade**2 * (3 - 2 * fade)
            through, polish = fade * shadow[:, None] + (1 - fade) * clear**2, 1.0
        mirrored = _gloss(n, v, unit(lamp[:3] + wet * v), f0[:, 0], roughness[:, 0])[:, None]
        gloss = lamp[6] * polish * mirrored * (wet + (1 - wet) * through * clear)
        diffuse = np.maximum(cosine + wrap, 0) / (1 + wrap) ** 2
        arriving = through + 1.2 * wrap * through * (1 - through)
        out = out + lamp[3:6] * (arriving * diffuse * albedo + gloss)
    bent = 1 - (1 - SHOULDER) * np.exp(np.minimum(SHOULDER - out, 0) / (1 - SHOULDER))
    return np.where(out > SHOULDER, bent, out).astype(np.float32)


def resolve(lit, pixels, backdrop, encode, supersample):
    """As `mien._kernels.shade.resolve`."""
    height, width, _ = backdrop.shape
    grid = np.zeros((height * supersample * width * supersample, 4))
    grid[pixels] = np.column_stack([lit, np.ones(len(lit))])
    mean = grid.reshape(height, supersample, width, supersample, 4).mean((1, 3))
    color, count = mean[..., :3], mean[..., 3:]
    alone = np.where(count > 0, color / np.where(count > 0, count, 1), 0)
    return _levels(color + (1 - count) * backdrop, encode), count[..., 0], _levels(alone, encode)


def _levels(linear, encode):
    place = np.sqrt(np.clip(linear, 0, 1)) * (len(encode) - 1)
    return (np.interp(place, np.arange(len(encode)), encode) + 0.5).astype(np.uint8)


def _gloss(n, v, lamp, f0, roughness):
    h = unit(lamp + v)
    cosine, nh, lh = (n * lamp).sum(1), (n * h).sum(1), (h * lamp).sum(1)
    d = nh**2 * (roughness**4 - 1) + 1
    fresnel = f0 + (1 - f0) * (1 - lh) ** 5
    gloss = cosine * fresnel * roughness**4 / (d**2 * 4 * np.maximum(lh**2, 0.1) * (roughness + 0.5))
    return np.where((cosine > 0) & (nh > 0), gloss, 0)


def unit(vectors):
    """Vectors (n, 3) of length one."""
    vectors = vectors.astype(float)
    return vectors / (np.linalg.norm(vectors, axis=1, keepdims=True) + 1e-12)
