"""Images as red and black halves, the order in which `mien._kernels.flow` works. Widths are even."""

import numpy as np
from jaxtyping import Float32


def pack(image: Float32[np.ndarray, "*c h w"]) -> Float32[np.ndarray, "2 *c h half"]:
    """Red and black pixels of an image: pixel (x, y) goes to [(x + y) % 2, ..., y, x // 2]."""
    halves = np.empty((2, *image.shape[:-1], image.shape[-1] // 2), np.float32)
    for k in (0, 1):
        halves[k, ..., 0::2, :] = image[..., 0::2, k::2]
        halves[k, ..., 1::2, :] = image[..., 1::2, 1 - k :: 2]
    return halves


def unpack(halves: Float32[np.ndarray, "2 h half"]) -> Float32[np.ndarray, "h w"]:
    """The image whose halves these are."""
    image = np.empty((halves.shape[1], 2 * halves.shape[2]), np.float32)
    for k in (0, 1):
        image[0::2, k::2] = halves[k, 0::2]
        image[1::2, 1 - k :: 2] = halves[k, 1::2]
    return image


def framed(image: Float32[np.ndarray, "h w"]) -> Float32[np.ndarray, "2 hh half"]:
    """The halves of an image with a frame of one entry all round, that holds the border's values."""
    halves = np.pad(pack(image), ((0, 0), (1, 1), (1, 1)))
    fill_frame(halves)
    return halves


def fill_frame(halves: Float32[np.ndarray, "2 hh half"]) -> None:
    """Set the frame to its neighbours in the other half, in place: then nothing changes across the border."""
    halves[:, 0], halves[:, -1] = halves[::-1, 1], halves[::-1, -2]
    halves[:, :, 0], halves[:, :, -1] = halves[::-1, :, 1], halves[::-1, :, -2]


def clear_border(edges: Float32[np.ndarray, "2 4 h half"]) -> None:
    """Cut the edges (left, right, up, down) that lead out of the image, in place."""
    for k in (0, 1):
        edges[k, 0, k::2, 0] = 0
        edges[k, 1, 1 - k :: 2, -1] = 0
        edges[k, 2, 0] = 0
        edges[k, 3, -1] = 0
