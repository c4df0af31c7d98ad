"""A net of triangles."""

import numpy as np


def net(rng, count=9, spread=0.3):
    """A jittered grid that covers 20 x 20 pixels, triangles all turned the same way."""
    x, y = np.meshgrid(np.linspace(2, 17, count), np.linspace(2, 17, count))
    places = np.stack([x, y], -1).reshape(-1, 2) + spread * rng.standard_normal((count * count, 2))
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel()
    return places, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
