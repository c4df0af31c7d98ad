"""Flow of a whole take's modes: found as it was played, by all frames together, and none where nothing moves."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from mien.tracking.relearn.shape_flow import (
    ShapeFlowConfig,
    blurred_picture,
    blurred_reference,
    difference,
    evidence,
    shape_flow,
    warped,
    weight_modes,
)

SHAPE, FRAMES = (64, 72), 8
CONFIG = ShapeFlowConfig(modes=3, smoothness=1.0, blurs=(4.0, 4.0, 2.0, 2.0, 1.0))


@cache
def skin():
    """Freckles, sharp enough to tell where they are."""
    return (3 * gaussian_filter(np.random.default_rng(0).normal(size=SHAPE), 2.0)).astype(np.float32)


def played():
    """Two shapes' weights, one frame at rest."""
    rng = np.random.default_rng(1)
    weights = rng.uniform(size=(FRAMES, 2))
    weights[0] = 0
    return weights


def motions():
    """What each shape does to the skin, pixels (2, 2, h, w): a shift to the right, and a swelling about the middle."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    swell = 0.08 * np.stack([x - SHAPE[1] / 2, y - SHAPE[0] / 2])
    return np.stack([np.stack([np.full(SHAPE, 2.5), np.zeros(SHAPE)]), swell])


def picture(flow, image=None):
    """What is seen where skin at x has gone to x + flow(x): read back to front, by fixed point."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    back = np.zeros((2, *SHAPE))
    for _ in range(8):
        back = np.stack([map_coordinates(each, [y - back[1], x - back[0]], order=1, mode="nearest") for each in flow])
    image = skin() if image is None else image
    return map_coordinates(image, [y - back[1], x - back[0]], order=3, mode="nearest").astype(np.float32)


def agreement(found, pictures):
    nothing = replace(found, flow=np.zeros_like(found.flow))
    after, before = (difference(flow, pictures, skin(), CONFIG).sum() for flow in (found, nothing))
    return after / before


def test_every_frame_s_flow_is_found_as_it_was_played():
    weights = played()
    true = np.einsum("tk,kchw->tchw", weights, motions())
    pictures = [picture(each) for each in true]
    found = shape_flow(pictures, skin(), weights, CONFIG)
    assert found.modes.shape[1] == 2
    inside = (slice(None), slice(10, -10), slice(10, -10))
    off = np.stack([found.of_frame(t)[inside] - true[t][inside] for t in range(FRAMES)])
    assert np.sqrt((off**2).mean()) < 0.15
    assert np.abs(true).max() > 2.5
    assert agreement(found, pictures) < 0.2
    np.testing.assert_allclose(found.of_frame(0), 0, atol=1e-9)


def test_light_that_is_no_motion_hardly_lets_pictures_agree():
    """Shades come with the weights: some flow is found, but pictures differ nearly as much with it."""
    weights, shade = played(), gaussian_filter(np.random.default_rng(2).normal(size=SHAPE), 3.0) * 8
    pictures = [(skin() + w.sum() * shade).astype(np.float32) for w in weights]
    found = shape_flow(pictures, skin(), weights, CONFIG)
    assert agreement(found, pictures) > 0.6


def test_what_is_not_known_counts_for_nothing():
    weights = played()
    true = np.einsum("tk,kchw->tchw", weights, motions())
    pictures = [picture(each) for each in true]
    clean = shape_flow(pictures, skin(), weights, CONFIG)
    hidden = pictures[3].copy()
    hidden[:, 30:] = np.nan
    some = shape_flow([*pictures[:3], hidden, *pictures[4:]], skin(), weights, CONFIG)
    inside = (slice(None), slice(10, -10), slice(10, -10))
    assert np.abs(some.of_frame(5)[inside] - clean.of_frame(5)[inside]).max() < 0.5
    assert np.isfinite(some.flow).all()


def test_a_frame_s_evidence_is_the_slope_of_its_difference():
    """By hand: for a picture a tenth of a pixel off, G^-1 q is that tenth where the skin shows something."""
    off = np.zeros((2, *SHAPE))
    off[0], off[1] = 0.1, -0.05
    level = blurred_reference(skin(), 1.0)
    slopes, seen = warped(blurred_picture(picture(off), 1.0), np.zeros((2, *SHAPE), np.float32), level)
    says = evidence(slopes, seen, level, epsilon=10.0)
    xx, xy, yy = (each[10:-10, 10:-10].sum() for each in says.G)
    q = says.q[:, 10:-10, 10:-10].sum(axis=(1, 2))
    np.testing.assert_allclose(np.linalg.solve([[xx, xy], [xy, yy]], q), [0.1, -0.05], atol=0.01)


def test_modes_say_all_of_the_weights_in_as_few_as_there_are():
    weights = played()
    double = np.concatenate([weights, weights], axis=1)
    modes = weight_modes(double, 10)
    assert modes.shape == (FRAMES, 2)
    np.testing.assert_allclose(modes @ modes.T, double @ double.T, atol=1e-12)
    assert weight_modes(double, 1).shape == (FRAMES, 1)
