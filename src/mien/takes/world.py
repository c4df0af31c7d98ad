"""The take's world: the lab turned to +Y up."""

import numpy as np

from ..transforms import Transform


def turn_y_up(T_lab_face: Transform) -> Transform:
    """Head poses with the lab turned by quarter turns so that its up axis is +Y: T_lab_face -> T_world_face.

    The up axis is the lab axis nearest to the mean direction of the top of the head. A lab that is +Y up already
    stays as it is.
    """
    up = T_lab_face.rotation[..., :, 1].mean(axis=0)
    axis = int(np.argmax(np.abs(up)))
    sign = np.sign(up[axis])
    if (axis, sign) == (1, 1.0):
        return T_lab_face
    y = sign * np.eye(3)[axis]
    x = np.eye(3)[(axis + 1) % 3]
    R = np.stack([x, y, np.cross(x, y)])
    turn = Transform(np.broadcast_to(R, T_lab_face.rotation.shape), np.zeros_like(T_lab_face.translation))
    return turn @ T_lab_face
