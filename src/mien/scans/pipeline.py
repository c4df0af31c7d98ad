"""A marker take and scans of its selected frames become a rig of the person (Huang et al. 2011, sec. 5-7)."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

import numpy as np
from jaxtyping import Bool, Float

from ..clip import Markers
from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..faces.scan_clean import cleaned
from ..fitting.register_scan import RegisterConfig, register_scan
from ..image_space.constraints import NamedConstraint, place_constraints, touched
from ..landmarks.on_scan import landmarks_near
from ..mesh import Attachment, Mesh, Scan
from ..mesh.scan_color import recoloured
from ..progress import SILENT, Progress
from ..register import Surface
from ..rig import Rig
from ..step_cache import Store
from ..takes.preprocess import PrepareConfig, PreparedTake, prepare
from ..takes.stabilise import calm_frames, mean_cloud
from ..transforms import Transform
from .fine_scale import FineConfig, FineResult, register_fine
from .marker_consensus import agreed_attachment, agreed_standoff
from .marker_registration import MarkersOnScans, OnScanConfig, packed, register_markers, unpacked
from .reconstruct import ReconstructConfig, meet_markers
from .scan_rig import ScanRig
from .template import (
    EIGHT,
    CoarseConfig,
    Landmarks,
    ScanTemplate,
    deform,
    laid_over,
    make_template,
    own_template,
    sound,
)


@dataclass(frozen=True)
class ScansConfig:
    """Everything that `mien register` may be told of a folder of scans."""

    density: int = 2
    """Rounds of subdivision of the bundled topology: 1 is 15,000 vertices of skin, 2 is 60,000."""
    prepare: PrepareConfig = PrepareConfig()
    reference: RegisterConfig = field(default_factory=RegisterConfig)
    """How the template is laid on the resting scan; the `density` above counts."""
    on_scan: OnScanConfig = OnScanConfig()
    coarse: CoarseConfig = field(default_factory=CoarseConfig)
    fine: FineConfig = field(default_factory=FineConfig)
    """Its `sweeps` 0 leaves the fine-scale step out."""
    reconstruct: ReconstructConfig = ReconstructConfig()


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
    landmarks: Landmarks | None


@dataclass(frozen=True)
class RegisteredScans:
    """Scans in one topology, the resting one first, and what is known of how good that is."""

    scan_rig: ScanRig
    scans: tuple[PlacedScan, ...]
    on_scans: MarkersOnScans
    template: ScanTemplate
    attachment: Attachment
    """Markers' skin points on the template's skin."""
    covered: Bool[np.ndarray, "scans markers"]
    """Markers over skin that both the scan and the resting one show."""
    coarse: Float[np.ndarray, "scans n 3"]
    """The template's skin after the large-scale step, face space, mm."""
    fine: FineResult
    """... and after the fine-scale step."""
    skin: Float[np.ndarray, "scans n 3"]
    """... and when it meets the markers."""
    unit: str
    """Of the scans' files."""


def register_scans(
    markers: Markers,
    scans: Sequence[Scan],
    frames: Sequence[int],
    face: BundledFace,
    config: ScansConfig = ScansConfig(),
    constraints: Sequence[NamedConstraint] = (),
    template: Scan | Literal["scan"] | None = None,
    store: Store = Store(None),
    progress: Progress = SILENT,
) -> RegisteredScans:
    """Scans of selected frames -> one topology, one rig, and the markers on it.

    Args:
        scans: as read from their files, in any frame; the i-th shows the expression of frame `frames[i]`.
        template: whose topology the rig gets: any mesh of a face, "scan" for the resting scan's own as in the paper,
            or None for the bundled face's, subdivided `config.density` times.
        constraints: correspondences by hand; only scans that they touch are aligned again.
        store: where finished steps are kept, and found again.

    Raises:
        BadInput: a frame that the take does not show, a scan that its markers do not fit, no face in the resting scan.
    """
    take = prepare(markers, config.prepare)
    scans, frames = resting_first(take, scans, frames)
    expressions = calmed(take.positions, frames, markers.rate)
    reference = _on_resting_scan(scans[0], config, store, progress)
    surfaces = [Surface(_cleaned(scan, reference.T_face_scan.scale)) for scan in scans]
    on_scans = _markers_on_scans(expressions, surfaces, scans, config.on_scan, store, progress)
    T_face_head = _rigid(reference.T_face_scan) @ on_scans.scans[0].T_head_scan.inverse()
    placed = _placed(scans, frames, surfaces, on_scans, T_face_head, reference, store, progress)
    surfaces = [Surface(scan.mesh) for scan in placed]
    on_resting = _template(template, reference, face, surfaces[0], config, store, progress)
    points = [found.attachment.points(scan.mesh) for scan, found in zip(placed, on_scans.scans, strict=True)]
    attachment = on_resting.attach(on_resting.skin.mesh.vertices, points[0])
    covered = np.stack([found.covered & on_scans.scans[0].covered for found in on_scans.scans])
    coarse = _large_scale(on_resting, placed, surfaces, attachment, points, covered, config.coarse, store, progress)
    fine = _fine_scale(on_resting, coarse, surfaces, config.fine, store, progress)
    if constraints:
        fine = _constrained(fine, constraints, on_resting, coarse, placed, surfaces, config.fine, store, progress)
    attachment = agreed_attachment(on_resting, fine.vertices, points, covered)
    goals = T_face_head.apply(expressions)
    standoff = agreed_standoff(on_resting, fine.vertices, attachment, goals, covered, on_scans.standoff)
    skin = meet_markers(
        on_resting.skin.mesh, fine.vertices, attachment, goals, standoff, covered, config.reconstruct
    )
    held = Attachment(on_resting.skin_faces[attachment.faces], attachment.barycentric)
    rig = _rig(on_resting, skin, [scan.name for scan in scans])
    on_skin = covered.mean(axis=0) > 0.5
    scan_rig = ScanRig(rig, scans[0].name, take.markers.labels, held, standoff, goals, on_skin)
    return RegisteredScans(
        scan_rig, placed, on_scans, on_resting, attachment, covered, coarse, fine, skin, reference.unit
    )


def resting_first(
    take: PreparedTake, scans: Sequence[Scan], frames: Sequence[int]
) -> tuple[list[Scan], list[int]]:
    """Scans and frames with the one closest to the take's calm face in front.

    Raises:
        BadInput: a frame that is not in the take, or shows too few markers.
    """
    for scan, frame in zip(scans, frames, strict=True):
        if frame not in take.analysed:
            raise BadInput(
                f"{scan.name}: frame {frame} is not in the take or shows too few markers (it has "
                f"{len(take.positions)} frames); is it the take that the selection was made from?"
            )
    calm = mean_cloud(take.positions, calm_frames(take.positions)[0])
    away = np.linalg.norm(take.positions[list(frames)] - calm, axis=2).mean(axis=1)
    order = [int(away.argmin()), *(i for i in range(len(frames)) if i != int(away.argmin()))]
    return [scans[i] for i in order], [frames[i] for i in order]


def calmed(
    positions: Float[np.ndarray, "frames markers 3"], frames: Sequence[int], rate: float
) -> Float[np.ndarray, "chosen markers 3"]:
    """The markers of selected frames, the resting one first, with less jitter, mm: scans will meet them exactly.

    The resting frame is averaged with those most like it; a parabola through a tenth of a second smooths the others.
    """
    reach = max(1, round(0.05 * rate))
    out = [mean_cloud(positions, frames[0])]
    for frame in frames[1:]:
        near = np.arange(max(0, frame - reach), min(len(positions), frame + reach + 1))
        near = near[np.isfinite(positions[near]).all(axis=(1, 2))]
        time = (near - frame) / reach
        powers = time[:, None] ** np.arange(min(3, len(near)))
        at_frame = np.linalg.pinv(powers)[0]
        out.append(np.tensordot(at_frame, positions[near], axes=1))
    return np.stack(out)


@dataclass(frozen=True)
class _Reference:
    """The template on the resting scan."""

    mesh: Mesh
    T_face_scan: Transform
    """Similarity."""
    landmarks: Landmarks
    unit: str


def _on_resting_scan(scan: Scan, config: ScansConfig, store: Store, progress: Progress) -> _Reference:
    settings = replace(config.reference, density=config.density)

    def make() -> dict[str, np.ndarray]:
        found = register_scan(scan, config=settings, progress=progress)
        T, mesh = found.T_face_scan, found.mesh
        arrays = {"vertices": mesh.vertices, "faces": mesh.faces, "rotation": T.rotation, "translation": T.translation}
        more = {"uv": mesh.uv, "uv_faces": mesh.uv_faces, "colors": mesh.colors}
        seen = {"points": found.landmarks.points, "spread": found.landmarks.spread}
        rest = {"scale": np.array(T.scale), "unit": np.array(found.landmarks.unit)}
        return arrays | {k: v for k, v in more.items() if v is not None} | seen | rest

    a = store.get("template", (scan.mesh.vertices, scan.mesh.faces, settings), make)
    T = Transform(a["rotation"], a["translation"], float(a["scale"]))
    mesh = Mesh(a["vertices"], a["faces"], a.get("uv"), a.get("uv_faces"), a.get("colors"))
    return _Reference(mesh, T, Landmarks(T.apply(a["points"]), a["spread"]), str(a["unit"]))


def _template(
    asked: Scan | Literal["scan"] | None, reference: _Reference, face: BundledFace, resting: Surface,
    config: ScansConfig, store: Store, progress: Progress,
) -> ScanTemplate:  # fmt: skip
    """The template, on the resting scan."""
    bundled = make_template(reference.mesh, face)
    if asked is None:
        return bundled
    if isinstance(asked, str):
        return own_template(sound(resting.mesh), bundled)
    other = _on_resting_scan(asked, config, store, progress)
    mesh = asked.mesh.with_vertices(other.T_face_scan.apply(asked.mesh.vertices))
    return own_template(laid_over(mesh, other.mesh, reference.mesh, resting), bundled)


def _cleaned(scan: Scan, scale: float) -> Mesh:
    """The scan's surface in millimetres, in its own frame, with its colours."""
    mesh = recoloured(cleaned(scan.mesh), scan)
    return mesh.with_vertices(scale * mesh.vertices)


def _rigid(T: Transform) -> Transform:
    return Transform(T.rotation, T.translation)


def _markers_on_scans(
    expressions: np.ndarray, surfaces: list[Surface], scans: list[Scan], config: OnScanConfig, store, progress
) -> MarkersOnScans:
    """Sec. 5, eq. 4-6."""
    meshes = [(surface.mesh.vertices, surface.mesh.faces) for surface in surfaces]

    def make() -> dict[str, np.ndarray]:
        return packed(register_markers(expressions, surfaces, config, progress, [scan.name for scan in scans]))

    return unpacked(store.get("markers", (expressions, meshes, config), make))


def _placed(
    scans: list[Scan], frames: list[int], surfaces: list[Surface], on_scans: MarkersOnScans, T_face_head: Transform,
    reference: _Reference, store: Store, progress: Progress,
) -> tuple[PlacedScan, ...]:  # fmt: skip
    """Scans in face space, and their landmarks."""
    scale, out = reference.T_face_scan.scale, []
    for i, (scan, found) in enumerate(zip(scans, on_scans.scans, strict=True)):
        rigid = T_face_head @ found.T_head_scan
        mesh = surfaces[i].mesh.with_vertices(rigid.apply(surfaces[i].mesh.vertices))
        T = rigid @ Transform(np.eye(3), np.zeros(3), scale)
        landmarks = reference.landmarks if i == 0 else _landmarks(scan, T, store)
        out.append(PlacedScan(scan.name, frames[i], mesh, T, landmarks))
        progress.update("lips and lids", i + 1, len(scans))
    return tuple(out)


def _landmarks(scan: Scan, T_face_scan: Transform, store: Store) -> Landmarks | None:
    def make() -> dict[str, np.ndarray]:
        seen = landmarks_near(scan, T_face_scan)
        return {} if seen is None else {"points": seen[0], "spread": seen[1]}

    a = store.get("landmarks", (scan.mesh.vertices, scan.mesh.faces, T_face_scan), make)
    return Landmarks(T_face_scan.apply(a["points"]), a["spread"]) if a else None


def _large_scale(
    template: ScanTemplate, placed: tuple[PlacedScan, ...], surfaces: list[Surface], attachment: Attachment,
    points: list[np.ndarray], covered: np.ndarray, config: CoarseConfig, store: Store, progress: Progress,
) -> Float[np.ndarray, "scans n 3"]:  # fmt: skip
    """Sec. 6.1, eq. 7. The resting scan has the template on it already."""
    out = [template.skin.mesh.vertices]
    for i in range(1, len(placed)):
        there, here = placed[0].landmarks, placed[i].landmarks
        seen = None if there is None or here is None else (there, here)

        def make(i: int = i, seen=seen) -> dict[str, np.ndarray]:
            skin = deform(template, surfaces[i], attachment, points[i], covered[i], seen, config)
            return {"skin": skin.astype(np.float32)}

        inputs = (template.mesh.vertices, placed[i].mesh.vertices, attachment, points[i], covered[i], seen, config)
        out.append(store.get("large", inputs, make)["skin"].astype(np.float64))
        progress.update("scans to one topology", i, len(placed) - 1)
    return np.stack(out)


def _fine_scale(
    template: ScanTemplate, coarse: np.ndarray, surfaces: list[Surface], config: FineConfig, store: Store, progress,
    **more: Any,
) -> FineResult:  # fmt: skip
    """Sec. 6.2, eq. 8-11."""
    regions = {name: template.regions[name] for name in EIGHT}

    def make() -> dict[str, np.ndarray]:
        found = register_fine(coarse, template.skin.mesh.faces, regions, surfaces, config, progress=progress, **more)
        slid = template.off_edges[:, None] * (found.vertices - coarse)
        return {field.name: getattr(found, field.name) for field in fields(FineResult)} | {"vertices": coarse + slid}

    return FineResult(**store.get("fine", (coarse, regions, template.off_edges, config, more), make))


def _constrained(
    fine: FineResult, constraints: Sequence[NamedConstraint], template, coarse, placed: tuple[PlacedScan, ...],
    surfaces, config: FineConfig, store: Store, progress: Progress,
) -> FineResult:  # fmt: skip
    """The same with correspondences by hand: what they touch is aligned again, the rest stays."""
    held = place_constraints(constraints, [p.name for p in placed], [p.T_face_scan for p in placed])
    again = {"constraints": held, "only": touched(held, fine.neighbours), "start": fine.vertices}
    return _fine_scale(template, coarse, surfaces, config, store, progress, **again)


def _rig(template: ScanTemplate, skin: Float[np.ndarray, "scans n 3"], names: list[str]) -> Rig:
    """The resting scan and a target for each other one, eyes and teeth and all."""
    rest, *others = (template.whole(x) for x in skin)
    deltas = np.zeros((0, *rest.shape)) if not others else np.stack(others) - rest
    return Rig(template.mesh.with_vertices(rest), deltas, tuple(names[1:]))
