"""What is shown and stored of registered scans: the page and the record of `mien register SCANS/`."""

import numpy as np
from jaxtyping import Float, UInt8

from ..image_space.features import raw_images
from ..image_space.layout import Layout
from ..mesh import Mesh, transfer
from ..pictures import contact_sheet, label
from ..pictures.colormap import colors_of
from ..pictures.render import Look, Renderer
from ..pictures.show import rig_look
from ..pictures.view import View, frontal_camera
from ..register import Rejection, Surface
from ..scans.pipeline import RegisteredScans, ScansConfig
from ..scans.scan_rig import marker_record
from ..scans.scan_template import FINE_REGIONS
from .markers import with_dots
from .page import Report
from .single_scan import pose_record
from .verdict import scans_verdict

LIMIT_MM = 0.5
"""Upper end of the distance maps."""
CURVED = 0.25
"""1/mm: both ends of the curvature maps."""
MOST = 8
"""Scans that are drawn; more make the page heavy."""


def surface_distances(found: RegisteredScans) -> Float[np.ndarray, "scans n"]:
    """From each vertex of the registered skin to its scan, mm; NaN off the open face and where nothing was scanned."""
    out = []
    face = (found.template.regions["face"] > 0.5) & found.template.shown
    for shape, scan in zip(found.fine.vertices, found.scans, strict=True):
        pairs = Surface(scan.mesh).correspond(shape, rejection=Rejection(max_distance=3.0))
        out.append(np.where(face & pairs.accepted, pairs.distances, np.nan))
    return np.stack(out)


def scans_record(found: RegisteredScans, distances: Float[np.ndarray, "scans n"], take: str) -> dict:
    """What `register.json` holds."""
    labels, scans = found.scan_rig.labels, {}
    for i, (scan, on) in enumerate(zip(found.scans, found.on_scans.scans, strict=True)):
        known = distances[i][np.isfinite(distances[i])]
        scans[scan.name] = {
            "frame": scan.frame,
            "T_face_scan": pose_record(scan.T_face_scan),
            "markers_rigid_rms_mm": round(on.rigid_rms, 4),
            "markers_not_on_scan": [labels[m] for m in np.flatnonzero(~on.covered)],
            "surface_mean_mm": round(float(known.mean()), 4) if len(known) else None,
            "surface_p95_mm": round(float(np.quantile(known, 0.95)), 4) if len(known) else None,
            "slid_mm": round(float(found.fine.moved[i]), 4),
            "fine_error_per_mm": dict(zip(FINE_REGIONS, found.fine.errors[i].round(4).tolist(), strict=True)),
            "flow_not_converged": [FINE_REGIONS[r] for r in np.flatnonzero(~found.fine.converged[i])],
            "unreliable": [FINE_REGIONS[r] for r in np.flatnonzero(found.fine.unreliable[i])],
        }
    out = {one.name: one.why for one in found.left_out}
    return {"take": take, "unit": found.unit, "scans": scans, "left_out": out, "markers": marker_record(found.scan_rig)}


def scans_report(
    title: str,
    found: RegisteredScans,
    distances: Float[np.ndarray, "scans n"],
    config: ScansConfig,
    verdict: str = "",
    moving: str | None = None,
) -> Report:
    """The page of `mien register SCANS/`: verdict, the moving face, worst regions, what to do; the rest is folded.

    Args:
        verdict: another, said before its own.
        moving: a page that plays the face.
    """
    known = distances[np.isfinite(distances)]
    lead = (
        f"{len(found.scans)} scans in one topology of {len(found.template.mesh.vertices):,} vertices; the neutral one "
        f"is {found.scan_rig.resting}. Registered skin to scan: mean {known.mean():.3f} mm, 95th percentile "
        f"{np.quantile(known, 0.95):.3f} mm."
    )
    worst = worst_regions(found)
    doubtful = [f"the {region} of {scan}" for region, scan, _, bad in worst if bad]
    own = scans_verdict(float(known.mean()), doubtful, found.fine.errors.size)
    report = Report(title, lead).verdict(f"{verdict} {own}".strip())
    if moving is not None:
        report.page(moving, "Drag to turn, wheel to come nearer; space plays.")
    report.figure(
        registered_sheet(found, distances),
        f"Each scan with its markers; registered; distance to the scan, 0 to {LIMIT_MM} mm (grey: nothing to compare).",
    )
    rows = [(region, scan, f"{error:.3f}", "no" if bad else "yes") for region, scan, error, bad in worst[:WORST]]
    report.heading("The worst regions").table(rows, ("region", "scan", "misfit, 1/mm", "reliable"))
    report.text(
        "Misfit is how far curvature is from the closest scans'. Look with `mien view` at the record (.register.json) "
        "and the folder of scans, click what is the same on both, and register again with --constraints. A mouth that "
        "one scan alone opens has nothing to be compared with, and is told as not reliable."
    )
    report.folded("Every scan, and every region", _tables(found, distances))
    return report.folded("What the fine-scale step does (the paper's figures)", _figures(found, config))


WORST = 5
"""Regions that a report names first."""


def worst_regions(found: RegisteredScans) -> list[tuple[str, str, float, bool]]:
    """Region, scan, misfit (1/mm), whether it is doubtful; what is doubtful first, then the largest."""
    fine = found.fine
    every = [
        (name.replace("_", " "), scan.name, float(fine.errors[i, r]), bool(fine.unreliable[i, r]))
        for i, scan in enumerate(found.scans)
        for r, name in enumerate(FINE_REGIONS)
    ]
    return sorted(every, key=lambda one: (one[3], one[2]), reverse=True)


def _tables(found: RegisteredScans, distances: Float[np.ndarray, "scans n"]) -> Report:
    header = ("scan", "frame", "markers, mm", "mean, mm", "95 %, mm")
    report = Report("").table(_scan_rows(found, distances), header)
    report.text(
        "Difference of the features from the neighbours' after the fine-scale step, 1/mm, by region. An exclamation "
        "mark: not reliable."
    )
    return report.table(_watch_rows(found), ("scan", *(name.replace("_", " ") for name in FINE_REGIONS)))


def _figures(found: RegisteredScans, config: ScansConfig) -> Report:
    report = Report("")
    report.figure(blend_picture(found), "Half-way between two scans, before and after (Huang 2011, fig. 5).")
    regions = "The eight regions, and the three scans closest to one in the forehead (fig. 6)."
    report.figure(region_picture(found), regions)
    laid_out = "Mean curvature laid out on a cylinder: a scan and its three closest (fig. 7)."
    return report.figure(curvature_picture(found, config), laid_out)


def _scan_rows(found: RegisteredScans, distances: np.ndarray) -> list[tuple]:
    rows = []
    for scan, on, d in zip(found.scans, found.on_scans.scans, distances, strict=True):
        mean, p95 = np.nanmean(d), np.nanquantile(d, 0.95)
        rows.append((scan.name, str(scan.frame), f"{on.rigid_rms:.2f}", f"{mean:.3f}", f"{p95:.3f}"))
    return rows


def _watch_rows(found: RegisteredScans) -> list[tuple]:
    fine = found.fine
    return [
        (scan.name, *(f"{e:.3f}{' !' * bool(bad)}" for e, bad in zip(fine.errors[i], fine.unreliable[i], strict=True)))
        for i, scan in enumerate(found.scans)
    ]


def registered_sheet(
    found: RegisteredScans, distances: Float[np.ndarray, "scans n"], size: int = 230
) -> UInt8[np.ndarray, "h w 3"]:
    """Scan, target of the rig and distance map, a row a scan."""
    view, rig = _front(found, size), found.scan_rig.rig
    plain = Renderer(rig.neutral, rig_look(rig.neutral))
    heat = Renderer(rig.neutral, Look(supersample=1, occlusion=0, limits=(0.0, LIMIT_MM)))
    images, captions = [], []
    for i, scan in enumerate(found.scans[:MOST]):
        dots = found.on_scans.scans[i].attachment.points(scan.mesh)[found.covered[i]]
        drawn = Renderer(scan.mesh, Look(supersample=2, occlusion=0)).draw(*view)
        vertices = rig.neutral.vertices + (rig.deltas[i - 1] if i else 0.0)
        values = np.full(len(vertices), np.nan)
        values[found.template.members] = distances[i]
        images += [with_dots(drawn, view, dots), plain.draw(*view, vertices=vertices)]
        images.append(heat.draw(*view, vertices=vertices, values=values))
        captions += [scan.name, "registered", "distance"]
    return contact_sheet(images, captions, columns=6)


def blend_picture(found: RegisteredScans, size: int = 420) -> UInt8[np.ndarray, "h w 3"]:
    """Fig. 5: two scans mixed half and half, without and with the fine-scale step, where it moved most.

    Scans with colour show it best: what does not correspond is seen twice.
    """
    i = int(found.fine.moved.argmax())
    j = int(found.fine.neighbours[i, 0, 0])
    view, faces, pictures = _front(found, size), found.template.skin.faces, []
    for shapes in (found.coarse, found.fine.vertices):
        colours = [_colours(found.scans[k].mesh, shapes[k]) for k in (i, j)]
        both = None if colours[0] is None or colours[1] is None else (colours[0] + colours[1]) / 2
        mesh = Mesh((shapes[i] + shapes[j]) / 2, faces, colors=both)
        pictures.append(Renderer(mesh, Look(supersample=2)).draw(*view))
    return contact_sheet(pictures, ["without the fine-scale step", "with it"], columns=2)


def _colours(scan: Mesh, vertices: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"] | None:
    """The scan's colours on a registered skin."""
    return None if scan.colors is None else np.clip(transfer(scan, scan.colors, vertices), 0, 1)


def region_picture(found: RegisteredScans, size: int = 260) -> UInt8[np.ndarray, "h w 3"]:
    """Fig. 6: the regions in colour, then a scan and the three closest to it in the left forehead."""
    faces, regions = found.template.skin.faces, found.template.regions
    masks = np.stack([regions[name] for name in FINE_REGIONS], 1)
    tints = colors_of(np.linspace(0.05, 0.95, len(FINE_REGIONS)), (0.0, 1.0), "heat")[[0, 4, 1, 5, 2, 6, 3, 7]]
    share = np.clip(masks.sum(axis=1, keepdims=True), 1e-9, None)
    tinted = np.where(masks.max(axis=1, keepdims=True) > 0.3, masks @ tints / share, 0.75)
    view = _front(found, size)
    mesh = Mesh(found.fine.vertices[0], faces, colors=np.clip(tinted, 0, 1))
    images, captions = [Renderer(mesh, Look(supersample=2)).draw(*view)], ["regions"]
    i = int(found.fine.moved.argmax())
    for k in (i, *found.fine.neighbours[i, 0]):
        mesh = Mesh(found.fine.vertices[k], faces)
        images.append(Renderer(mesh, Look(supersample=2)).draw(*view))
        captions.append(found.scans[k].name)
    return contact_sheet(images, captions, columns=len(images))


def curvature_picture(found: RegisteredScans, config: ScansConfig) -> UInt8[np.ndarray, "h w 3"]:
    """Fig. 7: mean curvature of a scan and its three closest in the mouth region, laid out."""
    regions = {name: found.template.regions[name] for name in FINE_REGIONS}
    i = int(found.fine.moved.argmax())
    mean = found.template.skin.with_vertices(found.fine.vertices.mean(axis=0))
    layout = Layout(mean, regions, config.fine.pixel_mm, config.fine.alpha)
    images, captions = [], []
    for k in (i, *found.fine.neighbours[i, FINE_REGIONS.index("mouth")]):
        shape = layout.mesh.with_vertices(found.fine.vertices[k][layout.vertices])
        scan = Surface(found.scans[k].mesh)
        curvature, _ = raw_images(shape, layout.image, scan, config.fine)
        colours = colors_of(curvature, (-CURVED, CURVED), "diverging")
        images.append(label((255 * colours).astype(np.uint8), found.scans[k].name))
        captions.append(found.scans[k].name)
    return contact_sheet(images, captions, columns=2)


def _front(found: RegisteredScans, size: int) -> View:
    shown = found.template.regions["face"] > 0.5
    mesh = Mesh(found.skin[0], found.template.skin.faces)
    return frontal_camera(mesh, size, frame=found.skin[:, shown].reshape(-1, 3)[::7])
