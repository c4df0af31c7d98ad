"""A rig made of scans, and the markers on it: what `mien register` leaves for `mien solve`."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from ..errors import BadInput
from ..files import existing, whole
from ..mesh import Attachment
from ..rig import Rig
from .scan_template import ScanTemplate


@dataclass(frozen=True)
class ScanRig:
    """Scanned expressions of one person in one topology, with the markers of the frames that they were scanned for."""

    rig: Rig
    """The resting scan, and a target for each other one; face space, mm."""
    resting: str
    """Name of the scan that is the rig's neutral."""
    labels: tuple[str, ...]
    """Markers."""
    attachment: Attachment
    """The skin points under them, on the rig's neutral."""
    standoff: Float[np.ndarray, " markers"]
    """Marker centres above the skin, mm."""
    expressions: Float[np.ndarray, "scans markers 3"]
    """Where the markers are on the resting scan and on each target, face space, mm."""
    on_skin: Bool[np.ndarray, " markers"]
    """False where the scans show no skin under a marker."""


def rig_of_scans(
    template: ScanTemplate,
    skin: Float[np.ndarray, "scans n 3"],
    names: list[str],
    colours: Float[np.ndarray, "all 3"] | None = None,
) -> Rig:
    """The neutral scan and a target for each other one, eyes and teeth and all; sRGB as given, or the template's."""
    neutral, *others = (template.whole(shape) for shape in skin)
    deltas = np.zeros((0, *neutral.shape)) if not others else np.stack(others) - neutral
    mesh = template.mesh.with_vertices(neutral)
    mesh = mesh if colours is None else replace(mesh, colors=colours)
    return Rig(mesh, deltas, tuple(names[1:]))


def marker_record(found: ScanRig) -> dict:
    """What `register.json` holds of a scan rig's markers."""
    places = np.column_stack([found.attachment.faces, found.attachment.barycentric.round(7)])
    return {
        "resting": found.resting,
        "labels": list(found.labels),
        "attachment": [[int(face), *weights] for face, *weights in places.tolist()],
        "standoff_mm": found.standoff.round(4).tolist(),
        "on_skin": found.on_skin.tolist(),
        "expressions_mm": dict(
            zip((found.resting, *found.rig.names), found.expressions.round(4).tolist(), strict=True)
        ),
    }


def record_beside(rig: Path) -> Path:
    """Where `mien register` writes what is known of a rig: `face.glb` -> `face.register.json`."""
    return rig.with_suffix(".register.json")


def write_record(path: Path, record: dict) -> None:
    """Write `register.json`."""
    with whole(path) as temporary:
        temporary.write_text(json.dumps(record, indent=1) + "\n")


def read_scan_rig(path: Path, rig: Rig) -> ScanRig:
    """The markers on a rig, from its record.

    Raises:
        BadInput: no record, not one, or one of another rig.
    """
    try:
        record = json.loads(existing(path).read_text())["markers"]
        places = np.array(record["attachment"], dtype=np.float64).reshape(-1, 4)
        expressions = record["expressions_mm"]
        resting = str(record["resting"])
        found = ScanRig(
            rig=rig,
            resting=resting,
            labels=tuple(record["labels"]),
            attachment=Attachment(places[:, 0].astype(np.int64), places[:, 1:].copy()),
            standoff=np.array(record["standoff_mm"], dtype=np.float64),
            expressions=np.array([expressions[name] for name in (resting, *rig.names)], dtype=np.float64),
            on_skin=np.array(record["on_skin"], dtype=bool),
        )
    except (json.JSONDecodeError, UnicodeDecodeError, KeyError, TypeError, ValueError) as error:
        told = str(error).splitlines()[:1] or [type(error).__name__]
        raise BadInput(f"{path}: does not belong to this rig ({told[0]}); run `mien register` again") from None
    if len(places) and int(found.attachment.faces.max()) >= len(rig.neutral.faces):
        raise BadInput(f"{path}: does not belong to this rig (it has fewer triangles); run `mien register` again")
    return found
