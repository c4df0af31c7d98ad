"""A synthesis as files: one mesh a frame with the head where it was, or a film with the head still."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ...errors import BadInput
from ...io.meshes.ply import write_ply
from ...pictures import Renderer, ambient_occlusion, frontal_camera, write_mp4
from ..drive import Drive
from ..synthesize import SynthesizedFrame, Synthesizer

FILM_PIXELS = 720
"""Side of a film's picture."""


def write_frames(folder: Path, synthesizer: Synthesizer, drive: Drive, frames: Iterable[SynthesizedFrame]) -> int:
    """`frame_000000.ply`, ...: one topology, texture coordinates of the base, the take's own frame of reference, mm.

    Raises:
        BadInput: the folder stands there as a file.
    """
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"{folder}: a file; name a folder for the frames, or a film (.mp4)")
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for count, frame in enumerate(frames, 1):
        vertices = drive.T_lab_face[count - 1].apply(frame.vertices.astype(float))
        write_ply(folder / f"frame_{count - 1:06d}.ply", synthesizer.mesh.with_vertices(vertices))
    return count


def write_film(path: Path, synthesizer: Synthesizer, frames: Iterable[SynthesizedFrame], rate: float) -> int:
    """The face from the front, shaded, the head still."""
    renderer, view = Renderer(synthesizer.mesh), frontal_camera(synthesizer.mesh, FILM_PIXELS)
    sky = ambient_occlusion(synthesizer.mesh)
    pictures = (
        renderer.draw(view.camera, view.T_camera_face, vertices=frame.vertices.astype(np.float64), open_sky=sky)
        for frame in frames
    )
    return write_mp4(path, pictures, rate)
