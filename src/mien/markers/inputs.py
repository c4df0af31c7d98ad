"""What the marker commands need from files: a face to solve on, and markers placed by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ..clip import Markers
from ..faces import BundledFace, IdentitySpace, load_face
from ..io.rigs import read_any_rig
from ..mesh import Attachment
from ..rig import Rig
from ..takes.told_frame import told_frame
from .attachment_file import labels_off_face, read_attachment
from .pipeline import TakeConfig


def read_face(rig: Path | None) -> BundledFace:
    """The bundled face, or a rig from a file treated as one: no identity space, every vertex of it skin."""
    if rig is None:
        return load_face()
    return face_from_rig(read_any_rig(rig))


def face_from_rig(rig: Rig) -> BundledFace:
    """A rig of one person as a face to solve on. With the bundled topology it keeps the bundled regions."""
    bundled = load_face()
    n = len(rig.neutral.vertices)
    nobody = IdentitySpace(np.zeros((0, n, 3)))
    if np.array_equal(rig.neutral.faces, bundled.rig.neutral.faces):
        return BundledFace(rig, nobody, bundled.mirror, bundled.parts, bundled.regions, {})
    everything = np.arange(n)
    return BundledFace(rig, nobody, everything, {"skin": everything}, {"face": np.ones(n)}, {})


def with_neutral(config: TakeConfig, told: str, rate: float) -> TakeConfig:
    """The configuration with the neutral frame that `--neutral` names: a frame (120) or a time (2.5s, 0.7).

    Raises:
        BadInput: neither.
    """
    frame = told_frame(told, rate, "--neutral")
    neutral = replace(config.calibrate.neutral, frame=frame)
    return replace(config, calibrate=replace(config.calibrate, neutral=neutral))


def read_placement(path: Path | None, markers: Markers, face: BundledFace) -> tuple[Markers, Attachment | None]:
    """The take's markers and the attachment of `--attach`, or None; markers it puts off the face are left out."""
    if path is None:
        return markers, None
    off = labels_off_face(path)
    here = markers.only(np.array([i for i, label in enumerate(markers.labels) if label not in off], dtype=np.int64))
    return here, read_attachment(path, here.labels, len(face.rig.neutral.faces))
