"""Inner loops of the photometric term: contrast of a picture, and what it shows at each vertex."""

from typing import no_type_check

import numba
import numpy as np

MATHS = {"reassoc", "contract", "arcp", "nsz"}


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def four_means(a, b, c, d, radius, to_a, to_b, to_c, to_d):
    """Running means over 2 radius + 1 pixels of four rows at once: alone, each sum would wait for the one before."""
    w = a.size
    s, t, u, v = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
    for j in range(min(radius, w)):
        s, t, u, v = s + a[j], t + b[j], u + c[j], v + d[j]
    for j in range(w):
        new, old = j + radius, j - radius - 1
        if new < w:
            s, t, u, v = s + a[new], t + b[new], u + c[new], v + d[new]
        if old >= 0:
            s, t, u, v = s - a[old], t - b[old], u - c[old], v - d[old]
        share = np.float32(1) / np.float32(min(new, w - 1) - max(old, -1))
        to_a[j], to_b[j], to_c[j], to_d[j] = s * share, t * share, u * share, v * share


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def add(line, factor, row):
    """line += factor row, in place."""
    for j in range(line.size):
        line[j] += factor * row[j]


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def box(image, radius):
    """Mean over (2 radius + 1)^2 pixels (h, w) float32, of those inside the picture."""
    h, w = image.shape
    rows, out = np.empty((h, w), np.float32), np.zeros((h, w), np.float32)
    for i in range(0, h, 4):
        j, k, m = min(i + 1, h - 1), min(i + 2, h - 1), min(i + 3, h - 1)
        four_means(image[i], image[j], image[k], image[m], radius, rows[i], rows[j], rows[k], rows[m])
    one = np.float32(1)
    total = np.zeros(w, np.float32)
    for i in range(min(radius, h)):
        add(total, one, rows[i])
    for i in range(h):
        if i + radius < h:
            add(total, one, rows[i + radius])
        if i - radius - 1 >= 0:
            add(total, -one, rows[i - radius - 1])
        add(out[i], one / np.float32(min(i + radius, h - 1) - max(i - radius, 0) + 1), total)
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def grey(color):
    """(r + 2 g + b) / 4 of (h, w, 3) uint8, as (h, w) float32."""
    h, w = color.shape[:2]
    out = np.empty((h, w), np.float32)
    for i in range(h):
        for j in range(w):
            out[i, j] = np.float32(0.25) * (color[i, j, 0] + 2.0 * color[i, j, 1] + color[i, j, 2])
    return out


@no_type_check
@numba.njit(cache=True, nogil=True, fastmath=MATHS, error_model="numpy")
def sample_plane(points, normals, image, intrinsics, reference, valid, agree):
    """What the picture says of each vertex, as a plane that it should lie on.

    With I the picture and p a vertex, a small motion d changes what it shows by g'd, g the picture's gradient taken
    back to camera space. It should show `reference`, so g'd = reference - I(p): the form of a point-to-plane row, with
    g for a normal (not of unit length) and p + g (reference - I) / g'g for the point.

    Args:
        points, normals: (n, 3) float32, camera space, mm.
        image: (h, w) float32.
        intrinsics: fx, fy, cx, cy of that image, float64.
        reference, valid: (n,) float32, what to find; weight, 0 = none is known.
        agree: least cosine of the normal to the line of sight.

    Returns:
        found, plane (n, 3) float32; weight (n,) float32: cosine to the line of sight times `valid`, 0 where nothing is
        seen; shown (n,) float32: the picture at each vertex.
    """
    n = points.shape[0]
    h, w = image.shape
    found, plane = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32)
    weight, shown = np.zeros(n, np.float32), np.zeros(n, np.float32)
    fx, fy, cx, cy = np.float32(intrinsics[0]), np.float32(intrinsics[1]), intrinsics[2], intrinsics[3]
    for i in range(n):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if not z > 1:
            continue
        facing = -(normals[i, 0] * x + normals[i, 1] * y + normals[i, 2] * z) / np.sqrt(x * x + y * y + z * z)
        u, v = fx * x / z + cx, fy * y / z + cy
        if facing < agree or not (u >= 1 and v >= 1 and u < w - 2 and v < h - 2):
            continue
        a, b = int(u), int(v)
        s, t = np.float32(u - a), np.float32(v - b)
        one = np.float32(1)
        p00, p01, p10, p11 = image[b, a], image[b, a + 1], image[b + 1, a], image[b + 1, a + 1]
        shown[i] = (one - t) * ((one - s) * p00 + s * p01) + t * ((one - s) * p10 + s * p11)
        gu = (one - t) * ((one - s) * (p01 - image[b, a - 1]) + s * (image[b, a + 2] - p00))
        gu += t * ((one - s) * (p11 - image[b + 1, a - 1]) + s * (image[b + 1, a + 2] - p10))
        gv = (one - s) * ((one - t) * (p10 - image[b - 1, a]) + t * (image[b + 2, a] - p00))
        gv += s * ((one - t) * (p11 - image[b - 1, a + 1]) + t * (image[b + 2, a + 1] - p01))
        gx, gy = np.float32(0.5) * gu * fx / z, np.float32(0.5) * gv * fy / z
        gz = -(gx * x + gy * y) / z
        square = gx * gx + gy * gy + gz * gz
        weight[i] = facing * valid[i]
        if not square > 1e-12:
            continue
        step = (reference[i] - shown[i]) / square
        plane[i, 0], plane[i, 1], plane[i, 2] = gx, gy, gz
        found[i, 0], found[i, 1], found[i, 2] = x + step * gx, y + step * gy, z + step * gz
    return found, plane, weight, shown
