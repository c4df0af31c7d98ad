"""Where to stand: cameras that frame a face."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..camera import Camera
from ..mesh import Mesh
from ..transforms import Transform, rotation_from_vector


class View(NamedTuple):
    """A camera and where it stands: `render(mesh, *view)`."""

    camera: Camera
    T_camera_face: Transform


def frontal_camera(
    mesh: Mesh,
    size: int | tuple[int, int],
    yaw: float = 0.0,
    pitch: float = 0.0,
    fov_deg: float = 24.0,
    margin: float = 0.06,
    frame: Float[np.ndarray, "p 3"] | None = None,
) -> View:
    """A camera in front of a face (face space: +Y up, +Z out of the face) that has all of it in the picture.

    Args:
        mesh: what is to be seen, millimetres.
        size: (width, height) in pixels, or one number for a square.
        yaw: radians that the camera goes round towards the subject's left (+X).
        pitch: radians that it goes up.
        fov_deg: angle of view over the shorter side of the picture, degrees.
        margin: share of the picture left free on every side.
        frame: the points to frame, such as a subset of the vertices; all vertices where None.
    """
    width, height = (size, size) if isinstance(size, int) else size
    points = mesh.vertices if frame is None else frame
    focal = min(width, height) / 2 / np.tan(np.radians(fov_deg) / 2)
    camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
    turn = rotation_from_vector(np.array([pitch, 0.0, 0.0])) @ rotation_from_vector(np.array([0.0, -yaw, 0.0]))
    rotation = np.diag([1.0, -1.0, -1.0]) @ turn
    seen = points @ rotation.T
    free = 1 - 2 * margin
    reach = np.array([width, height]) / 2 / focal * free
    offset = np.append((seen[:, :2].min(0) + seen[:, :2].max(0)) / 2, 0.0)
    for _ in range(4):
        local = seen - offset
        distance = max(((np.abs(local[:, :2]) / reach).max(1) - local[:, 2]).max(), 1e-3 - local[:, 2].min())
        image = local[:, :2] / (local[:, 2:] + distance)
        middle = (image.min(0) + image.max(0)) / 2
        offset[:2] += middle * distance
    return View(camera, Transform(rotation, np.array([0.0, 0.0, distance]) - offset))
