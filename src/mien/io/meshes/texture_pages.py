"""Several pictures of one mesh (texture pages) as one: the pages above each other, coordinates moved onto them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, UInt8
from PIL import Image

from ...errors import BadInput
from ...mesh import Mesh
from .images import read_image

Pages = tuple[Path | None, ...]
"""Pictures of a mesh; None for the plain grey of materials that have none."""
_GREY = 128


def page_sizes(paths: Sequence[Path | None]) -> Int[np.ndarray, "pages 2"]:
    """Width and height of each picture; a pixel of plain grey for None.

    Raises:
        BadInput: one that is no picture.
    """
    sizes = []
    for path in paths:
        if path is None:
            sizes.append((1, 1))
            continue
        try:
            with Image.open(path) as image:
                sizes.append(image.size)
        except (OSError, ValueError, SyntaxError) as error:
            raise BadInput(f"{path}: is no picture that can be read ({error}); give PNG or JPEG") from None
    return np.array(sizes, np.int64)


def read_pages(paths: Sequence[Path | None]) -> UInt8[np.ndarray, "h w 3"]:
    """The pages above each other, the first on top, each at the left; grey where a page is narrower than the widest."""
    plain = np.full((1, 1, 3), _GREY, np.uint8)
    pages = [plain if path is None else read_image(path) for path in paths]
    width = max(page.shape[1] for page in pages)
    padded = [np.pad(p, ((0, 0), (0, width - p.shape[1]), (0, 0)), constant_values=_GREY) for p in pages]
    return np.concatenate(padded)


def mesh_on_pages(mesh: Mesh, page: Int[np.ndarray, " m"], paths: Sequence[Path | None]) -> Mesh:
    """The mesh with every triangle's texture coordinates on its own page (see `on_pages`).

    Raises:
        BadInput: a page that is no picture.
    """
    assert mesh.uv is not None
    corners = mesh.uv[mesh.faces if mesh.uv_faces is None else mesh.uv_faces]
    uv = on_pages(corners, page, page_sizes(paths)).reshape(-1, 2)
    return replace(mesh, uv=uv, uv_faces=np.arange(len(uv)).reshape(-1, 3))


def on_pages(
    uv: Float[np.ndarray, "m 3 2"], page: Int[np.ndarray, " m"], sizes: Int[np.ndarray, "pages 2"]
) -> Float[np.ndarray, "m 3 2"]:
    """Texture coordinates of triangles' corners on their own pages -> on all pages above each other.

    A triangle that lies beyond the unit square of a repeated picture is moved back by whole repeats; on a page of one
    pixel all corners are in its middle, where no other page shines through.
    """
    repeats = np.floor(uv.min(axis=1, keepdims=True) + 1e-9)
    inside = np.clip(uv - repeats, 0.0, 1.0)
    total, width = sizes[:, 1].sum(), sizes[:, 0].max()
    below = total - np.cumsum(sizes[:, 1])
    inside[(sizes[page] == 1).all(axis=1)] = 0.5
    u = inside[..., 0] * (sizes[page, 0] / width)[:, None]
    v = (inside[..., 1] * sizes[page, 1][:, None] + below[page][:, None]) / total
    return np.stack([u, v], axis=-1)
