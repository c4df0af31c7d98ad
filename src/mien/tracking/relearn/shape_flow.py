"""How skin slips in all pictures of a take at once: one flow for each mode of the weights (Garg et al. 2013).

In frame t the skin at a place x of the chart has gone to x + u_t(x), u_t = sum_k Phi_tk d_k: Phi are the weights'
modes, the d_k are sought. Frame by frame flow is noisy, and its smoothness makes it too small; here every frame speaks
of the same few d_k, and nothing but they is held smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import gaussian_filter, map_coordinates

from .node_grid import NodeGrid, node_grid, solve_smoothly

THIN = 0.05
"""Share of known pixels nearby below which a blurred picture says nothing."""
RIM = 2.0
"""Pixels: what is nearer than about that to where the reference is not known is left out."""
FAINT = 0.5
"""Bend of the picture, over its root mean square, that counts half: strong features do not rule all."""
LEAST_MODE = 1e-3
"""Modes weaker than this share of the strongest are none."""


@dataclass(frozen=True)
class ShapeFlowConfig:
    """The flow of a take's modes, in pixels of the chart."""

    modes: int = 10
    """At most so many modes of the weights, the strongest."""
    node: int = 4
    """Distance of the nodes between which flow is linear."""
    blurs: tuple[float, ...] = (4.0, 4.0, 4.0, 2.0, 2.0, 2.0, 1.0, 1.0)
    """Deviations of the Gaussians by which pictures are blurred, a linearisation each."""
    epsilon: float = 0.5
    """Differences well below it count by their square, well above it by their size."""
    smoothness: float = 6.0
    """Weight of each squared difference between neighbouring nodes, a frame."""
    small: float = 0.01
    """Weight of each squared flow, a frame."""


@dataclass(frozen=True)
class ShapeFlow:
    """What was found."""

    modes: Float[np.ndarray, "frames m"]
    """Phi: how strong each mode is in each frame."""
    grid: NodeGrid
    flow: Float[np.ndarray, "n m 2"]
    """d: what each mode does to each node, pixels (x, y)."""

    def of_frame(self, frame: int) -> Float32[np.ndarray, "2 h w"]:
        """u_t, pixels (x, y)."""
        return self.grid.between(np.einsum("m,nmd->nd", self.modes[frame], self.flow))


@dataclass(frozen=True)
class BlurredSkin:
    """The reference, blurred."""

    slopes: Float32[np.ndarray, "2 h w"]
    """Its derivatives along x and y: the two channels that are compared. Brightness itself is left to the light."""
    bends: Float32[np.ndarray, "2 2 h w"]
    """Theirs along x and y."""
    faint: Float[np.ndarray, " 2"]
    """Added to each channel's squared bend."""
    inside: Bool[np.ndarray, "h w"]
    """Where the reference is known well enough."""


@dataclass(frozen=True)
class BlurredPicture:
    """A frame's picture, blurred as the reference is."""

    shown: Float32[np.ndarray, "h w"]
    known: Float32[np.ndarray, "h w"]
    """1 where the picture itself is known, else 0."""


@dataclass(frozen=True)
class Evidence:
    """What a frame says of each pixel's flow beyond what it was warped by: minimise d'G d - 2 q'd."""

    G: Float32[np.ndarray, "3 h w"]
    """xx, xy, yy."""
    q: Float32[np.ndarray, "2 h w"]
    """x, y."""


def shape_flow(
    pictures: Sequence[Float32[np.ndarray, "h w"]],
    reference: Float32[np.ndarray, "h w"],
    weights: Float[np.ndarray, "frames k"],
    config: ShapeFlowConfig = ShapeFlowConfig(),
) -> ShapeFlow:
    """The flow of the weights' modes that brings all pictures nearest to the reference; NaN is not known.

    Weights are 0 where the face is as in the reference.
    """
    modes = weight_modes(weights, config.modes)
    grid = node_grid(np.isfinite(reference), config.node)
    flow = np.zeros((int(grid.there.sum()), modes.shape[1], 2))
    found = ShapeFlow(modes, grid, flow)
    for blur, steps in groupby(config.blurs):
        level = blurred_reference(reference, blur)
        blurred = [blurred_picture(picture, blur) for picture in pictures]
        for _ in steps:
            found = one_step(found, blurred, level, config)
    return found


def weight_modes(weights: Float[np.ndarray, "frames k"], most: int) -> Float[np.ndarray, "frames m"]:
    """The weights' principal components, each as strong as it is."""
    U, s, _ = np.linalg.svd(weights, full_matrices=False)
    count = min(most, int((s > LEAST_MODE * s[0]).sum()))
    return (U * s)[:, : max(count, 1)]


def one_step(
    now: ShapeFlow, pictures: Sequence[BlurredPicture], level: BlurredSkin, config: ShapeFlowConfig
) -> ShapeFlow:
    """One Gauss-Newton step from the flow as it is: all frames' normal equations, node by node, then one solve."""
    nodes, m, _ = now.flow.shape
    G, q = np.zeros((len(pictures), nodes, 3)), np.zeros((len(pictures), nodes, 2))
    for t, picture in enumerate(pictures):
        says = evidence(*warped(picture, now.of_frame(t), level), level, config.epsilon)
        G[t], q[t] = now.grid.summed(says.G), now.grid.summed(says.q)
    pairs = now.modes[:, :, None] * now.modes[:, None]
    A = np.tensordot(G[:, :, [[0, 1], [1, 2]]], pairs, (0, 0))
    A = A.transpose(0, 3, 1, 4, 2).reshape(nodes, 2 * m, 2 * m)
    b = np.tensordot(q, now.modes, (0, 0)).transpose(0, 2, 1)
    start = now.flow.reshape(nodes, 2 * m)
    right = b.reshape(nodes, 2 * m) + np.einsum("nij,nj->ni", A, start)
    smoothness, small = config.smoothness * len(pictures), config.small * len(pictures)
    found = solve_smoothly(now.grid, A, right, start, smoothness, small)
    return replace(now, flow=found.reshape(now.flow.shape))


def difference(
    now: ShapeFlow,
    pictures: Sequence[Float32[np.ndarray, "h w"]],
    reference: Float32[np.ndarray, "h w"],
    config: ShapeFlowConfig = ShapeFlowConfig(),
) -> Float[np.ndarray, " n"]:
    """How far the pictures differ from the reference about each node, at the finest level; summed over the frames."""
    blur = config.blurs[-1]
    total, level = np.zeros(len(now.flow)), blurred_reference(reference, blur)
    square = (level.bends**2).sum(axis=1) + level.faint[:, None, None]
    for t, picture in enumerate(pictures):
        slopes, seen = warped(blurred_picture(picture, blur), now.of_frame(t), level)
        ratio = (level.slopes - slopes) ** 2 / square / config.epsilon**2
        each = np.where(seen, np.sqrt(1 + ratio) - 1, 0.0)
        total += now.grid.summed(each).sum(axis=1)
    return total


def blurred_reference(reference: Float32[np.ndarray, "h w"], blur: float) -> BlurredSkin:
    """The reference as it is compared."""
    known = np.isfinite(reference)
    slopes = _slopes(_blurred(reference, blur))
    bends = np.stack([_slopes(each) for each in slopes])
    inside = gaussian_filter(known.astype(np.float32), RIM) > 1 - THIN / 2
    square = (bends**2).sum(axis=1)[:, inside]
    return BlurredSkin(slopes, bends, FAINT**2 * square.mean(axis=1) if inside.any() else np.ones(2), inside)


def blurred_picture(picture: Float32[np.ndarray, "h w"], blur: float) -> BlurredPicture:
    """A picture as it is compared, NaN where it is not known; `blur` in pixels."""
    return BlurredPicture(_blurred(picture, blur), np.isfinite(picture).astype(np.float32))


def warped(
    picture: BlurredPicture, flow: Float32[np.ndarray, "2 h w"], level: BlurredSkin
) -> tuple[Float32[np.ndarray, "2 h w"], Bool[np.ndarray, "h w"]]:
    """The picture's slopes, read where the flow says, and where they are known."""
    rows, columns = np.indices(picture.shown.shape, dtype=np.float32)
    at = [rows + flow[1], columns + flow[0]]
    read = map_coordinates(picture.shown, at, order=1, mode="nearest")
    seen = map_coordinates(picture.known, at, order=1, mode="nearest") > 0.99
    return _slopes(read), seen & level.inside


def evidence(
    slopes: Float32[np.ndarray, "2 h w"], seen: Bool[np.ndarray, "h w"], level: BlurredSkin, epsilon: float
) -> Evidence:
    """The channels' differences, linear in the flow, over how much a pixel of flow changes them.

    sum_c ((bend_c . d - off_c) / size_c)^2, weighted by 1 / sqrt(1 + (off_c / size_c / epsilon)^2); bends are the mean
    of the picture's and the reference's.
    """
    shape = level.inside.shape
    G, q = np.zeros((3, *shape), np.float32), np.zeros((2, *shape), np.float32)
    for channel in range(2):
        x, y = (_slopes(slopes[channel]) + level.bends[channel]) / 2
        off = level.slopes[channel] - slopes[channel]
        square = x**2 + y**2 + level.faint[channel]
        robust = np.sqrt(1 + off**2 / square / epsilon**2)
        trust = np.where(seen, 1 / square / robust, 0)
        G += trust * np.stack([x * x, x * y, y * y])
        q += trust * off * np.stack([x, y])
    return Evidence(G, q)


def _blurred(picture: Float32[np.ndarray, "h w"], blur: float) -> Float32[np.ndarray, "h w"]:
    known = np.isfinite(picture)
    share = gaussian_filter(known.astype(np.float32), blur)
    return gaussian_filter(np.where(known, picture, 0), blur) / np.maximum(share, THIN)


def _slopes(image: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "2 h w"]:
    """Derivatives along x and y."""
    along_y, along_x = np.gradient(image)
    return np.stack([along_x, along_y])
