"""What a picture needs at every sample: attributes carried from corners, texture, light. Compiled, one row a sample."""

from typing import no_type_check

import numpy as np
from numba import njit

from ._spread import spread

SHOULDER = 0.75
"""Linear light above this bends smoothly towards 1, so that highlights keep their shape."""

WET = (0.04, 0.22)
"""Reflectance and roughness of a wet surface."""


def interpolate(values, corners, weights, threads=0):
    """Corner values at samples.

    Args:
        values: (n, c).
        corners: (s, 3) rows of `values`.
        weights: (s, 3) barycentric coordinates.

    Returns:
        (s, c) float32.
    """
    values = np.ascontiguousarray(values, dtype=np.float32)
    corners = np.ascontiguousarray(corners, dtype=np.int64)
    weights = np.ascontiguousarray(weights, dtype=np.float64)
    out = np.empty((len(corners), values.shape[1]), np.float32)
    spread(lambda a, b: _interpolate(values, corners, weights, a, b, out), len(corners), threads)
    return out


def bilinear(texture, curve, uv, threads=0):
    """Texture colour at samples, through `curve`, between texels, repeated outside 0..1.

    Args:
        texture: (h, w, 3) uint8, first row at the top.
        curve: (256,) float32, what each level means (linear light).
        uv: (s, 2) float32, origin at the lower left corner of the image, texel centres at half texels.

    Returns:
        (s, 3) float32.
    """
    texture = np.ascontiguousarray(texture, dtype=np.uint8)
    uv = np.ascontiguousarray(uv, dtype=np.float32)
    out = np.empty((len(uv), 3), np.float32)
    curve = np.ascontiguousarray(curve, dtype=np.float32)
    spread(lambda a, b: _bilinear(texture, curve, uv, a, b, out), len(uv), threads)
    return out


def lift(points, normals, corners, weights, threads=0):
    """Samples moved from their flat triangles out to the smooth surface that the vertex normals speak of, so that
    coarse triangles do not shadow themselves where the smooth surface would not (Hanika 2021).

    Args:
        points, normals: (n, 3) of the vertices; unit normals.
        corners: (s, 3).
        weights: (s, 3) barycentric coordinates.

    Returns:
        (s, 3) float32.
    """
    points, normals, weights = (np.ascontiguousarray(x, dtype=np.float64) for x in (points, normals, weights))
    corners = np.ascontiguousarray(corners, dtype=np.int64)
    out = np.empty((len(corners), 3), np.float32)
    spread(lambda a, b: _lift(points, normals, corners, weights, a, b, out), len(corners), threads)
    return out


def light(normals, points, albedo, open_sky, shadow, wet, lamps, ambient, skin, threads=0):
    """Light that leaves each sample towards the camera at the origin, linear.

    Diffuse light wraps round the terminator by `skin[c]`, a share of one, in each colour (light bleeds under the skin,
    farthest in red); gloss is one GGX lobe with Schlick's Fresnel term (Walter et al. 2007; Kelemen's visibility).

    Args:
        normals, points: (s, 3) float32, camera space; normals face the camera, of any length.
        albedo: (s, 3) float32, linear.
        open_sky: (s,) float32, 1 = unoccluded.
        shadow: (s,) float32, the share of lamp 0 that arrives.
        wet: (s,) float32, 0 = as `skin` says, 1 = wet like an eye.
        lamps: (l, 7): unit direction towards the lamp, colour, share of it that mirrors.
        ambient: (2, 3): light from above (-y) and from below.
        skin: (5,): wrap in red, green, blue; reflectance at normal incidence; roughness.

    Returns:
        (s, 3) float32.
    """
    n, p, al = (np.ascontiguousarray(x, dtype=np.float32) for x in (normals, points, albedo))
    shares = np.ascontiguousarray(np.stack([open_sky, shadow, wet], 1), dtype=np.float32)
    lamps, ambient, skin = (np.ascontiguousarray(x, dtype=np.float32) for x in (lamps, ambient, skin))
    out = np.empty((len(normals), 3), np.float32)
    spread(lambda a, b: _light(n, p, al, shares, lamps, ambient, skin, a, b, out), len(normals), threads)
    return out


def resolve(lit, pixels, backdrop, encode, supersample):
    """Samples -> 8-bit pixels over a backdrop.

    Args:
        lit: (s, 3) float32, linear.
        pixels: (s,) int64, flat index of each sample in the supersampled picture.
        backdrop: (h, w, 3) float32, linear.
        encode: (levels,) float32, sRGB 0..255 of linear light at squares of equal steps over 0..1.
        supersample: samples a side in every pixel.

    Returns:
        RGB (h, w, 3) uint8 over the backdrop; coverage (h, w) float32; RGB on its own, straight (h, w, 3) uint8.
    """
    height, width, _ = backdrop.shape
    sums, count = np.zeros((height, width, 3), np.float32), np.zeros((height, width), np.float32)
    over, alone = np.zeros((height, width, 3), np.uint8), np.zeros((height, width, 3), np.uint8)
    share = 1 / supersample**2
    _gather(np.ascontiguousarray(lit, dtype=np.float32), pixels.astype(np.int64), supersample, share, sums, count)
    _encode(sums, count, np.ascontiguousarray(backdrop, dtype=np.float32), encode.astype(np.float32), over, alone)
    return over, count, alone


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _interpolate(values, corners, weights, first, last, out):
    for s in range(first, last):
        i, j, k = corners[s, 0], corners[s, 1], corners[s, 2]
        a, b, g = weights[s, 0], weights[s, 1], weights[s, 2]
        for c in range(values.shape[1]):
            out[s, c] = a * values[i, c] + b * values[j, c] + g * values[k, c]


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _lift(points, normals, corners, weights, first, last, out):
    for s in range(first, last):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            w, corner = weights[s, k], points[corners[s, k]]
            x, y, z = x + w * corner[0], y + w * corner[1], z + w * corner[2]
        dx, dy, dz = 0.0, 0.0, 0.0
        for k in range(3):
            corner, n = points[corners[s, k]], normals[corners[s, k]]
            below = (x - corner[0]) * n[0] + (y - corner[1]) * n[1] + (z - corner[2]) * n[2]
            rise = -weights[s, k] * min(below, 0.0)
            dx, dy, dz = dx + rise * n[0], dy + rise * n[1], dz + rise * n[2]
        out[s, 0], out[s, 1], out[s, 2] = x + dx, y + dy, z + dz


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _bilinear(texture, curve, uv, first, last, out):
    height, width, _ = texture.shape
    for s in range(first, last):
        x = uv[s, 0] * width - 0.5
        y = (1 - uv[s, 1]) * height - 0.5
        left, top = np.floor(x), np.floor(y)
        fx, fy = x - left, y - top
        i0, j0 = int(left) % width, int(top) % height
        i1, j1 = (i0 + 1) % width, (j0 + 1) % height
        for c in range(3):
            above = (1 - fx) * curve[texture[j0, i0, c]] + fx * curve[texture[j0, i1, c]]
            below = (1 - fx) * curve[texture[j1, i0, c]] + fx * curve[texture[j1, i1, c]]
            out[s, c] = (1 - fy) * above + fy * below


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def unit(x, y, z):
    """A vector of length one."""
    length = np.sqrt(x * x + y * y + z * z) + 1e-12
    return x / length, y / length, z / length


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _fresnel(f0, cosine):
    away = 1 - cosine
    square = away * away
    return f0 + (1 - f0) * square * square * away


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _gloss(n, v, l, f0, roughness):
    """Mirrored share of a lamp in direction l, GGX with Kelemen's visibility, times pi."""
    hx, hy, hz = l[0] + v[0], l[1] + v[1], l[2] + v[2]
    cosine = n[0] * l[0] + n[1] * l[1] + n[2] * l[2]
    nh = n[0] * hx + n[1] * hy + n[2] * hz
    if cosine <= 0 or nh <= 0:
        return 0.0
    length = hx * hx + hy * hy + hz * hz  # squared; v and l are units, so l.h = |v + l| / 2
    alpha = roughness * roughness
    d = nh * nh / length * (alpha * alpha - 1) + 1
    mirrored = cosine * alpha * alpha * _fresnel(f0, 0.5 * np.sqrt(length))
    return mirrored / (d * d * max(length, 0.4) * (roughness + 0.5))


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _light(normals, points, albedo, shares, lamps, ambient, skin, first, last, out):
    for s in range(first, last):
        n = unit(normals[s, 0], normals[s, 1], normals[s, 2])
        v = unit(-points[s, 0], -points[s, 1], -points[s, 2])
        sky, clear, wet = 0.5 - 0.5 * n[1], shares[s, 0], shares[s, 2]
        f0, roughness = skin[3] + wet * (WET[0] - skin[3]), skin[4] + wet * (WET[1] - skin[4])
        # rough dark hair has little of the sheen that smooth skin has at a grazing angle
        smooth = min(4 * (albedo[s, 0] + albedo[s, 1] + albedo[s, 2]) / 3 + wet, 1.0)
        facing = max(n[0] * v[0] + n[1] * v[1] + n[2] * v[2], 0.0)
        sheen = _fresnel(f0, facing) * 0.35 * clear * clear * smooth
        for c in range(3):
            around = sky * ambient[0, c] + (1 - sky) * ambient[1, c]
            # light that bounces between bright walls of a fold before it comes out
            out[s, c] = around * (albedo[s, c] * clear / (1 - albedo[s, c] * (1 - clear) * 0.8) + sheen)
        for lamp in range(len(lamps)):
            l = (lamps[lamp, 0], lamps[lamp, 1], lamps[lamp, 2])
            cosine = n[0] * l[0] + n[1] * l[1] + n[2] * l[2]
            if wet == 0 and cosine + max(skin[0], skin[1], skin[2]) <= 0:
                continue
            through, polish = 0.4 * clear + 0.6 * clear * clear, smooth
            if lamp == 0:
                # past the terminator the lamp's shadow says nothing: there the open sky decides
                fade = min(max(cosine / 0.25, 0.0), 1.0)
                fade = fade * fade * (3 - 2 * fade)
                through, polish = fade * shares[s, 1] + (1 - fade) * clear * clear, 1.0
            if wet > 0:
                # a cornea bulges from its ball and looks out from under the lids: lamps mirror nearer its middle
                l = unit(l[0] + wet * v[0], l[1] + wet * v[1], l[2] + wet * v[2])
            gloss = lamps[lamp, 6] * polish * _gloss(n, v, l, f0, roughness) * (wet + (1 - wet) * through * clear)
            for c in range(3):
                diffuse = max(cosine + skin[c], 0.0) / ((1 + skin[c]) * (1 + skin[c]))
                # red light bleeds into the edge of a shadow first
                arriving = through + 1.2 * skin[c] * through * (1 - through)
                out[s, c] += lamps[lamp, 3 + c] * (arriving * diffuse * albedo[s, c] + gloss)
        for c in range(3):
            if out[s, c] > SHOULDER:
                out[s, c] = 1 - (1 - SHOULDER) * np.exp((SHOULDER - out[s, c]) / (1 - SHOULDER))


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _gather(lit, pixels, supersample, share, sums, count):
    wide = count.shape[1] * supersample
    for s in range(len(pixels)):
        v, u = pixels[s] // wide // supersample, pixels[s] % wide // supersample
        count[v, u] += share
        for c in range(3):
            sums[v, u, c] += share * lit[s, c]


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _level(linear, encode):
    place = np.sqrt(min(max(linear, 0.0), 1.0)) * (len(encode) - 1)
    below = min(int(place), len(encode) - 2)
    return int(encode[below] + (place - below) * (encode[below + 1] - encode[below]) + 0.5)


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _encode(sums, count, backdrop, encode, over, alone):
    height, width = count.shape
    for v in range(height):
        for u in range(width):
            free = 1 - count[v, u]
            for c in range(3):
                over[v, u, c] = _level(sums[v, u, c] + free * backdrop[v, u, c], encode)
                if count[v, u] > 0:
                    alone[v, u, c] = _level(sums[v, u, c] / count[v, u], encode)
