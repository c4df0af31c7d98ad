"""What a scan shows by itself, without markers: its surface, its face, and the bundled topology on it."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..faces.scan_clean import check_scan, cleaned
from ..fitting.register_scan import RegisterConfig, Registration, register_scan
from ..mesh import Mesh, Scan, closest_point
from ..mesh.scan_color import recoloured
from ..transforms import Transform
from .left_out import LeftOut
from .scan_template import person_on


@dataclass(frozen=True)
class FittedScan:
    """A scan of a selected frame."""

    scan: Scan
    """As read from its file."""
    frame: int
    """Of the take."""
    surface: Mesh
    """Cleaned, in the file's frame and unit; colours on the vertices if the scan has any."""
    fit: Registration | None
    """The bundled topology on it; None where no face was found, so that markers alone can place it."""

    @property
    def name(self) -> str:
        """The file's stem."""
        return self.scan.name

    def unit_mm(self, otherwise: float) -> float:
        """Millimetres in one unit of its file; `otherwise` where the scan does not tell."""
        known = self.fit is not None and self.fit.landmarks.unit != "unknown"
        return self.fit.T_face_scan.scale if self.fit is not None and known else otherwise


def fit_scan(scan: Scan, frame: int, config: RegisterConfig) -> FittedScan | LeftOut:
    """Find the face in a scan and lay the bundled topology on it (Huang et al. 2011, sec. 6.1, with landmarks)."""
    try:
        check_scan(scan)
    except BadInput as error:
        return LeftOut(scan.name, str(error))
    surface = recoloured(cleaned(scan.mesh), scan)
    try:
        fit = register_scan(scan, config=config)
    except BadInput:
        fit = None
    return FittedScan(scan, frame, surface, fit)


def fit_template(neutral: FittedScan, density: int, config: RegisterConfig) -> Registration:
    """The bundled topology, subdivided `density` times, on the neutral scan.

    Raises:
        BadInput: no face was found in it.
    """
    if neutral.fit is None:
        raise BadInput(f"{neutral.name}: no face found in the neutral scan; crop it to the head")
    settings = replace(config, density=density)
    return register_scan(neutral.scan, landmarks=neutral.fit.landmarks, config=settings)


def shapes_at_markers(
    neutral: FittedScan,
    markers: Float[np.ndarray, "markers 3"],
    T_face_head: Transform | None,
    face: BundledFace,
) -> Float[np.ndarray, "shapes markers 3"]:
    """How the bundled face's expressions, on the neutral scan, move the markers of its frame; head frame, mm.

    None where the scan shows no face.

    Args:
        markers: head frame, mm.
        T_face_head: rigid.
    """
    if neutral.fit is None or T_face_head is None:
        return np.zeros((0, *markers.shape))
    person = person_on(neutral.fit.mesh, face)
    D = closest_point(person.neutral, T_face_head.apply(markers)).attachment().matrix(person.neutral)
    return T_face_head.inverse().rotate(np.stack([D @ delta for delta in person.deltas]))
