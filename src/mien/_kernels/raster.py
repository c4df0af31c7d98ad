"""Scanline conversion of triangles. `raster_twin` has the numpy twin."""

from typing import no_type_check

import numpy as np
from numba import njit


@no_type_check
@njit(cache=True, nogil=True, error_model="numpy")
def scan_convert(places, faces, owner, barycentric):
    """Which triangle covers each pixel centre, and where in it.

    places (n, 2): the vertices in pixels (x, y), centres at integers; faces (m, 3). owner (h, w) comes filled with -1
    and gets triangle numbers; barycentric (h, w, 3). On an edge, or where triangles overlap, the first one stays.
    Triangles of either orientation are drawn, those of no area are not.
    """
    h, w = owner.shape
    for f in range(len(faces)):
        a, b, c = places[faces[f, 0]], places[faces[f, 1]], places[faces[f, 2]]
        ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
        area = ux * vy - uy * vx
        if area == 0.0 or not np.isfinite(area):
            continue
        slack = 1e-9
        top = max(0, int(np.ceil(min(a[1], b[1], c[1]) - slack)))
        bottom = min(h - 1, int(np.floor(max(a[1], b[1], c[1]) + slack)))
        left = max(0, int(np.ceil(min(a[0], b[0], c[0]) - slack)))
        right = min(w - 1, int(np.floor(max(a[0], b[0], c[0]) + slack)))
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                px, py = x - a[0], y - a[1]
                beta, gamma = (px * vy - py * vx) / area, (ux * py - uy * px) / area
                alpha = 1.0 - beta - gamma
                if min(alpha, beta, gamma) >= -slack and owner[y, x] < 0:
                    owner[y, x] = f
                    barycentric[y, x, 0], barycentric[y, x, 1], barycentric[y, x, 2] = alpha, beta, gamma
