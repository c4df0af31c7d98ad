"""Scans where they belong: all in one face space, with their markers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from ..fitting.register_scan import Registration
from ..mesh import Mesh
from ..transforms import Transform, stacked
from .correspond.large_scale import ScanLandmarks
from .fitted_scan import FittedScan
from .marker_pose import ScannedFrame
from .marker_registration import MarkersOnScan, MarkersOnScans
from .take_in_head import TakeInHead


@dataclass(frozen=True)
class PlacedScan:
    """A scan where it belongs."""

    name: str
    frame: int
    """Of the take."""
    mesh: Mesh
    """Cleaned, face space, mm; colours on the vertices if the scan has any."""
    T_face_scan: Transform
    """Similarity: the file's frame and unit -> face space, mm."""
    landmarks: ScanLandmarks | None
    """Lips and lids as seen on it; None where no face was found."""

    def moved(self, T: Transform) -> "PlacedScan":
        """The same elsewhere in face space."""
        landmarks = self.landmarks and replace(self.landmarks, points=T.apply(self.landmarks.points))
        return replace(
            self,
            mesh=self.mesh.with_vertices(T.apply(self.mesh.vertices)),
            T_face_scan=T @ self.T_face_scan,
            landmarks=landmarks,
        )


@dataclass(frozen=True)
class PlacedScans:
    """All scans, the neutral one first."""

    take: TakeInHead
    on_scans: MarkersOnScans
    scans: tuple[PlacedScan, ...]
    T_face_head: Transform
    """Rigid, one a scan: the take's head as the scan's frame has it -> face space."""

    @property
    def markers(self) -> Float[np.ndarray, "scans markers 3"]:
        """Markers of the frames, face space, mm."""
        return self.T_face_head.apply(self.take.expressions)

    def moved(self, transforms: Sequence[Transform]) -> "PlacedScans":
        """The same with every scan, and the markers of its frame, moved rigidly in face space."""
        scans = tuple(scan.moved(T) for scan, T in zip(self.scans, transforms, strict=True))
        return replace(self, scans=scans, T_face_head=stacked(transforms) @ self.T_face_head)

    @property
    def skin_points(self) -> list[Float[np.ndarray, "markers 3"]]:
        """Points of each scan's skin under its markers, face space, mm."""
        return [on.attachment.points(scan.mesh) for on, scan in zip(self.on_scans.scans, self.scans, strict=True)]


def scanned_frames(take: TakeInHead) -> list[ScannedFrame]:
    """Scans in millimetres, each in its own frame, with their markers and their own faces' poses.

    A scan whose landmarks do not tell its unit has that of the neutral scan.
    """
    neutral = take.scans[0].fit
    size = 1.0 if neutral is None else neutral.T_face_scan.scale
    return [_scanned_frame(scan, x, size) for scan, x in zip(take.scans, take.expressions, strict=True)]


def _scanned_frame(scan: FittedScan, markers: np.ndarray, neutral_mm: float) -> ScannedFrame:
    millimetres = scan.unit_mm(neutral_mm)
    mesh = scan.surface.with_vertices(millimetres * scan.surface.vertices)
    return ScannedFrame(scan.name, markers, mesh, None if scan.fit is None else _own_pose(scan.fit, millimetres))


def _own_pose(fit: Registration, millimetres: float) -> Transform:
    """T_face_scan of a fit as a rigid transform of the scan in millimetres; the face's middle stays where it is."""
    back = fit.T_face_scan.inverse()
    middle = fit.mesh.vertices.mean(axis=0)
    turn = Transform(fit.T_face_scan.rotation, np.zeros(3))
    return Transform(turn.rotation, middle - turn.apply(millimetres * back.apply(middle[None]))[0])


def place_scans(
    take: TakeInHead, frames: Sequence[ScannedFrame], on_scans: MarkersOnScans, template: Registration
) -> PlacedScans:
    """Bring all scans into the face space of the neutral one, by way of the take's head."""
    T_face_head = _rigid(template.T_face_scan) @ on_scans.scans[0].T_head_scan.inverse()
    neutral_mm = template.T_face_scan.scale
    placed = [
        _placed(scan, frame, on, T_face_head, neutral_mm)
        for scan, frame, on in zip(take.scans, frames, on_scans.scans, strict=True)
    ]
    return PlacedScans(take, on_scans, tuple(placed), stacked([T_face_head] * len(placed)))


def _placed(
    scan: FittedScan, frame: ScannedFrame, on: MarkersOnScan, T_face_head: Transform, neutral_mm: float
) -> PlacedScan:
    T_face_mm = T_face_head @ on.T_head_scan
    T_face_scan = replace(T_face_mm, scale=scan.unit_mm(neutral_mm))
    mesh = frame.mesh.with_vertices(T_face_mm.apply(frame.mesh.vertices))
    if scan.fit is None:
        return PlacedScan(scan.name, scan.frame, mesh, T_face_scan, None)
    seen = scan.fit.landmarks
    landmarks = ScanLandmarks(T_face_scan.apply(seen.points), seen.disagreement)
    return PlacedScan(scan.name, scan.frame, mesh, T_face_scan, landmarks)


def _rigid(T: Transform) -> Transform:
    return Transform(T.rotation, T.translation)


def both_landmarks(neutral: PlacedScan, other: PlacedScan) -> tuple[ScanLandmarks, ScanLandmarks] | None:
    """Those of the neutral scan and of another, where both show a face."""
    if neutral.landmarks is None or other.landmarks is None:
        return None
    return neutral.landmarks, other.landmarks
