"""What is shown and stored of a registration: pictures, distance maps, figures by region."""

from dataclasses import asdict, replace

import numpy as np
from jaxtyping import UInt8
from PIL import Image, ImageDraw

from ..faces.bundled import load_face
from ..fitting.register_scan import Registration
from ..mesh import Mesh, Scan
from ..pictures.render import Look, Renderer
from ..pictures.view import View, frontal_camera
from ..transforms import Transform
from .page import Report

LIMIT_MM = 1.0
"""Upper end of the distance maps."""


def registration_pictures(scan: Scan, found: Registration, size: int = 420) -> UInt8[np.ndarray, "h w 3"]:
    """Scan with the registered lids and lips drawn on it, registered face, distance map; from the front and a side."""
    placed = replace(scan.mesh, vertices=found.T_face_scan.apply(scan.mesh.vertices))
    look = Look(supersample=1)
    front = found.mesh.vertices[(found.mesh.vertices[:, 2] > 40) & (np.abs(found.mesh.vertices[:, 1] + 20) < 95)]
    heat = np.where(found.reliable, found.distances, np.nan)
    on_scan, on_face = Renderer(placed, look, scan.texture), Renderer(found.mesh, replace(look, limits=(0.0, LIMIT_MM)))
    rows = []
    for yaw in (0.0, 0.6):
        view = frontal_camera(found.mesh, size, yaw, 0.0, frame=front)
        outlined = _with_edges(on_scan.draw(*view), view, found.mesh)
        rows.append(np.concatenate([outlined, on_face.draw(*view), on_face.draw(*view, values=heat)], axis=1))
    return np.concatenate(rows)


def _with_edges(image: UInt8[np.ndarray, "h w 3"], view: View, mesh: Mesh) -> UInt8[np.ndarray, "h w 3"]:
    """Lids and lips of the registered face as lines. (Subdivided, the coarse vertices still come first.)"""
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    for edge in load_face().contours.values():
        pixels = view.camera.project(view.T_camera_face.apply(mesh.vertices[edge]))
        draw.line([(float(u), float(v)) for u, v in pixels], fill=(255, 255, 255), width=1)
    return np.asarray(picture)


def pose_record(T: Transform) -> dict:
    """A similarity as the records hold it."""
    return {"rotation": T.rotation.tolist(), "translation_mm": T.translation.tolist(), "scale": T.scale}


def registration_record(found: Registration) -> dict:
    """What `register.json` holds of one scan."""
    return {
        "T_face_scan": pose_record(found.T_face_scan),
        "unit": found.landmarks.unit,
        "inside_out": found.landmarks.inside_out,
        "landmark_misfit_mm": found.landmarks.misfit,
        "regions": {name: _clean(asdict(error)) for name, error in found.regions.items()},
        "mended": list(found.mended),
        "unreliable": [name for name, error in found.regions.items() if error.covered < 0.5],
        "expression": {name: round(w, 4) for name, w in found.expression.items() if w > 0.01},
    }


def _clean(values: dict[str, float]) -> dict[str, float | None]:
    return {name: round(v, 4) if np.isfinite(v) else None for name, v in values.items()}


def registration_report(scan: Scan, found: Registration) -> Report:
    """The page of `mien register` for one scan."""
    whole = found.regions["face"]
    lead = (
        f"{len(scan.mesh.vertices)} vertices, unit: {found.landmarks.unit}. Mean distance {whole.mean:.3f} mm, "
        f"95th percentile {whole.p95:.3f} mm over the {whole.covered:.0%} of the face that the scan shows."
    )
    report = Report(f"{scan.name or 'scan'}: a scan in the bundled topology", lead)
    caption = "Scan with the registered lids and lips; registered face; distance to the scan, 0 to 1 mm, grey where "
    report.figure(registration_pictures(scan, found), caption + "there is nothing to compare with.")
    report.heading("Regions").table(
        [(name, f"{e.mean:.3f}", f"{e.p95:.3f}", f"{e.covered:.0%}") for name, e in found.regions.items()],
        ("region", "mean, mm", "95th percentile, mm", "covered"),
    )
    if found.mended:
        report.text(f"Put right in the scan: {'; '.join(found.mended)}.")
    doubtful = [name for name, e in found.regions.items() if e.covered < 0.5]
    if doubtful:
        report.text(f"Not reliable, since the scan shows less than half of them: {', '.join(doubtful)}.")
    return report
