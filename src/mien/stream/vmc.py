"""VMC, the Virtual Motion Capture protocol of avatar programs: Open Sound Control over UDP.

A frame is one bundle: `/VMC/Ext/OK`, `/VMC/Ext/T`, the head as a bone (`/VMC/Ext/Bone/Pos Head`), a weight a shape
(`/VMC/Ext/Blend/Val`), and `/VMC/Ext/Blend/Apply`. Axes are Unity's: left-handed, +Y up, the avatar looks along +Z, +X
is its right; metres; quaternions x, y, z, w.

A bone's position is one below its parent, which belongs to the avatar: programs that take it are told a usual neck, and
where the head goes in the room is not sent.
"""

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from .face_frame import FaceFrame

PORT = 39539
"""Where performers send and avatar programs listen."""
_HEAD_BONE_M = (0.0, 0.08, 0.0)
"""From the neck's bone to the head's, as avatars have it."""


def encode_frame(frame: FaceFrame, capitals: bool = False) -> bytes:
    """A frame's bundle. With `capitals` names are spelled `JawOpen`, as avatars for Perfect Sync have them."""
    from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder

    bundle = OscBundleBuilder(IMMEDIATELY)  # pyright: ignore[reportArgumentType]
    bundle.add_content(_message("/VMC/Ext/OK", 1))
    bundle.add_content(_message("/VMC/Ext/T", float(frame.number / frame.rate)))
    turned = unity_quaternion(frame.rotation).tolist()
    bundle.add_content(_message("/VMC/Ext/Bone/Pos", "Head", *_HEAD_BONE_M, *turned))
    for name, weight in frame.weights.items():
        spelled = name[0].upper() + name[1:] if capitals else name
        bundle.add_content(_message("/VMC/Ext/Blend/Val", spelled, weight))
    bundle.add_content(_message("/VMC/Ext/Blend/Apply"))
    return bundle.build().dgram


def unity_quaternion(rotation: Float[np.ndarray, "3 3"]) -> Float[np.ndarray, " 4"]:
    """A rotation of ours in Unity's axes: mirrored in x."""
    return Rotation.from_matrix(rotation).as_quat(canonical=True) * (1, -1, -1, 1)


def _message(address: str, *values: object):
    from pythonosc.osc_message_builder import OscMessageBuilder

    message = OscMessageBuilder(address)
    for value in values:
        message.add_arg(value)  # pyright: ignore[reportArgumentType]
    return message.build()
