"""A synthesis as files: one mesh a frame with the head where it was, or a film with the head still."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float32, UInt8

from ...errors import BadInput
from ...io.exr import write_exr
from ...io.meshes.ply import write_ply
from ...pictures import Renderer, ambient_occlusion, frontal_camera, write_mp4, write_png
from ...pictures.color import to_bytes
from ..drive import Drive
from ..fit import DetailModel
from ..sampling import interpolated
from ..synthesize import SynthesizedFrame, Synthesizer, coloured
from ..texture_space import texture_gradients, with_gutter

FILM_PIXELS = 720
"""Side of a film's picture."""


def write_frames(folder: Path, synthesizer: Synthesizer, drive: Drive, frames: Iterable[SynthesizedFrame]) -> int:
    """`frame_000000.ply`, ...: one topology, texture coordinates of the base, the take's own frame of reference, mm.

    Colours at the vertices where the maps have them. Where the frames carry the fine map, it comes as a displacement
    map, `fine_000000.exr`, and as a normal map, `normal_000000.png`.

    Raises:
        BadInput: the folder stands there as a file.
    """
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"{folder}: a file; name a folder for the frames, or a film (.mp4)")
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for count, frame in enumerate(frames, 1):
        vertices = drive.T_lab_face[count - 1].apply(frame.vertices.astype(float))
        number = f"{count - 1:06d}"
        write_ply(folder / f"frame_{number}.ply", coloured(synthesizer.mesh.with_vertices(vertices), frame))
        if frame.fine is not None:
            height = fine_image(synthesizer.model, frame.fine)
            write_exr(folder / f"fine_{number}.exr", {"height": height}, half=True)
            write_png(folder / f"normal_{number}.png", normal_image(synthesizer.model, height))
    return count


def fine_image(model: DetailModel, heights: Float32[np.ndarray, " p"]) -> Float32[np.ndarray, "size size"]:
    """The fine map as a displacement map: height along the normal, mm; beside the surface its nearest texel's."""
    assert model.fine is not None
    read = np.where(model.fine.unreliable, np.nan, heights)
    return with_gutter(model.fine.texels.image(read if np.isfinite(read).any() else heights)).astype(np.float32)


def fine_images(model: DetailModel, drive: Drive) -> Iterator[Float32[np.ndarray, "size size"]]:
    """The fine map of every frame (`fine_image`)."""
    assert model.fine is not None
    for vectors in model.domain.vectors(drive.positions):
        yield fine_image(model, model.fine.driven.values(vectors)[:, 0])


def normal_image(model: DetailModel, height: Float32[np.ndarray, "size size"]) -> UInt8[np.ndarray, "size size 3"]:
    """The same as a tangent-space normal map: x along u, y along v (up in the picture), z outwards."""
    assert model.fine is not None
    mesh, grid = model.base, model.fine.texels
    steps = np.stack([np.linalg.norm(G @ mesh.vertices, axis=1) for G in texture_gradients(mesh)], 1) / grid.size
    side = with_gutter(grid.image(interpolated(steps, grid.attachment, mesh.faces)))
    down, across = np.gradient(height)
    normals = np.stack([-across / side[..., 0], down / side[..., 1], np.ones_like(height)], -1)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return to_bytes(0.5 + 0.5 * normals)


def write_film(path: Path, synthesizer: Synthesizer, frames: Iterable[SynthesizedFrame], rate: float) -> int:
    """The face from the front, shaded, the head still; in its colours where the maps have them."""
    renderer, view = Renderer(synthesizer.mesh), frontal_camera(synthesizer.mesh, FILM_PIXELS)
    sky = ambient_occlusion(synthesizer.mesh)
    pictures = (
        renderer.with_colors(coloured(synthesizer.mesh, frame).colors).draw(
            view.camera, view.T_camera_face, vertices=frame.vertices.astype(np.float64), open_sky=sky
        )
        for frame in frames
    )
    return write_mp4(path, pictures, rate)
