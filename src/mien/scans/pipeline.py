"""A marker take and scans of its selected frames become a rig of the person (Huang et al. 2011, sec. 5-7)."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from ..clip import Markers
from ..faces.bundled import BundledFace
from ..fitting.register_scan import RegisterConfig, Registration, register_scan
from ..image_space.constraints import NamedConstraint, place_constraints, touched
from ..mesh import Attachment, Scan
from ..one_line import count, one_line
from ..progress import SILENT, Progress
from ..register import Surface
from ..step_cache import StepCache
from ..takes.preprocess import PreprocessTakeConfig, preprocess_take
from .correspond import large_scale
from .correspond.carried_skin import LeanConfig, lean_on_markers
from .correspond.fine_scale import FineConfig, FineResult, register_fine
from .correspond.large_scale import LargeScaleConfig, LargeScaleTarget
from .correspond.still_skin import StillSkinConfig, moved_shapes, settle_heads
from .fitted_scan import fit_scan, fit_template, shapes_at_markers
from .left_out import LeftOut, enough, kept
from .marker_consensus import consensus_attachment, consensus_standoff
from .marker_pose import ScannedFrame, find_poses, head_on_face
from .marker_registration import MarkerRegistrationConfig, MarkersOnScans, fit_markers_to_scans
from .placed_scans import PlacedScan, PlacedScans, both_landmarks, place_scans, scanned_frames
from .reconstruct import ReconstructConfig, meet_markers
from .scan_colours import rig_colours
from .scan_rig import ScanRig, rig_of_scans
from .scan_template import (
    FINE_REGIONS,
    ScanTemplate,
    make_template,
    manifold_part,
    own_template,
    transfer_topology,
)
from .take_in_head import TakeInHead, take_in_head

COVERED_SHARE = 0.5
"""A marker is on skin where more than this share of the scans shows some under it."""
FEWEST_SCANS = 2
"""A rig is a resting scan and at least one other."""


@dataclass(frozen=True)
class ScansConfig:
    """Everything that `mien register` may be told of a folder of scans."""

    density: int = 2
    """Rounds of subdivision of the bundled topology: 1 is 15,000 vertices of skin, 2 is 60,000."""
    strict: bool = False
    """Stop at a scan that cannot be used, instead of going on without it."""
    preprocess: PreprocessTakeConfig = PreprocessTakeConfig()
    fit: RegisterConfig = field(default_factory=RegisterConfig)
    """How the bundled face is laid on each scan by itself; the `density` above counts."""
    registration: MarkerRegistrationConfig = field(default_factory=MarkerRegistrationConfig)
    large: LargeScaleConfig = field(default_factory=LargeScaleConfig)
    still_skin: StillSkinConfig = field(default_factory=StillSkinConfig)
    fine: FineConfig = field(default_factory=FineConfig)  # its `sweeps` 0 leaves the step out
    lean: LeanConfig = field(default_factory=LeanConfig)
    reconstruct: ReconstructConfig = ReconstructConfig()


@dataclass(frozen=True)
class Corresponded:
    """Scans in one topology."""

    placed: PlacedScans
    template: ScanTemplate
    attachment: Attachment
    """Markers' skin points on the template's skin, as the neutral scan has them."""
    covered: Bool[np.ndarray, "scans markers"]
    """Markers over skin that both the scan and the neutral one show."""
    coarse: Float[np.ndarray, "scans n 3"]
    """The template's skin after the large-scale step, face space, mm."""
    fine: FineResult
    """... and after the fine-scale step."""


@dataclass(frozen=True)
class RegisteredScans:
    """Scans in one topology, the neutral one first, and what is known of how good that is."""

    scan_rig: ScanRig
    scans: tuple[PlacedScan, ...]
    on_scans: MarkersOnScans
    template: ScanTemplate
    attachment: Attachment
    """Markers' skin points on the template's skin."""
    covered: Bool[np.ndarray, "scans markers"]
    """Markers over skin that both the scan and the neutral one show."""
    coarse: Float[np.ndarray, "scans n 3"]
    fine: FineResult
    """As in `Corresponded`."""
    skin: Float[np.ndarray, "scans n 3"]  # ... and when it meets the markers
    unit: str
    """Of the scans' files."""
    left_out: tuple[LeftOut, ...]
    """Scans that the rig is made without."""

    def __repr__(self) -> str:
        left_out = f"{len(self.left_out)} left out" if self.left_out else ""
        return one_line(self, count(len(self.scans), "scans"), left_out, self.scan_rig.rig)


def register_scans(
    markers: Markers,
    scans: Sequence[Scan],
    frames: Sequence[int],
    face: BundledFace,
    config: ScansConfig = ScansConfig(),
    constraints: Sequence[NamedConstraint] = (),
    template: Scan | Literal["scan"] | None = None,
    work: Path | None = None,
    progress: Progress = SILENT,
) -> RegisteredScans:
    """Scans of selected frames -> one topology, one rig, and the markers on it.

    Args:
        scans: as read from their files, in any frame; the i-th shows the expression of frame `frames[i]`.
        template: whose topology the rig gets: any mesh of a face, "scan" for the neutral scan's own as in the paper,
            or None for the bundled face's, subdivided `config.density` times.
        constraints: correspondences by hand; only scans that they touch are aligned again.
        work: the folder in which finished steps are kept, and found again.

    Raises:
        BadInput: fewer than two scans can be used, or one cannot and `config.strict` is set.
    """
    cached = StepCache(work, progress)
    take = see_from_head(markers, scans, frames, config, cached)
    seen, scanned, on_scans = lay_markers(take, face, config, cached)  # eq. 4-6
    on_neutral = cached(fit_template, neutral=seen.scans[0], density=config.density, config=config.fit)
    placed = place_scans(seen, scanned, on_scans, on_neutral)
    topology = choose_template(template, on_neutral, placed, face, config, cached)
    placed_coarse = correspond_coarsely(topology, placed, config.large, cached)  # eq. 7
    coarse = hold_heads_still(placed_coarse, config.still_skin, cached)
    fine = correspond_finely(coarse, config.fine, constraints, cached)  # eq. 8-11
    return build_rig(fine, on_neutral, config)  # sec. 7


def see_from_head(
    markers: Markers, scans: Sequence[Scan], frames: Sequence[int], config: ScansConfig, cached: StepCache
) -> TakeInHead:
    """Each scan by itself, and the take seen from its head."""
    inputs = []
    for scan, frame in zip(scans, frames, strict=True):
        inputs.append({"scan": scan, "frame": frame, "config": config.fit})
    found = cached.each("the face in every scan", fit_scan, inputs)
    fitted, out = kept(found, config.strict)
    enough(len(fitted), FEWEST_SCANS, out)
    preprocessed = preprocess_take(markers, config.preprocess)
    take = take_in_head(preprocessed, fitted, config.strict)
    enough(len(take.scans), FEWEST_SCANS, out + take.left_out)
    everyone = range(len(take.scans))
    return take.only(everyone, out)


def lay_markers(
    take: TakeInHead, face: BundledFace, config: ScansConfig, cached: StepCache
) -> tuple[TakeInHead, list[ScannedFrame], MarkersOnScans]:
    """Sec. 5: markers on the scans that they fit."""
    scanned = scanned_frames(take)
    found = cached(find_poses, frames=scanned, config=config.registration.pose)
    poses, out = kept(found, config.strict)
    rows = [i for i, pose in enumerate(found) if not isinstance(pose, LeftOut)]
    enough(len(rows), FEWEST_SCANS, take.left_out + out)
    fitting, seen = [scanned[i] for i in rows], take.only(rows, out)
    shapes = shapes_at_markers(seen.scans[0], fitting[0].markers, head_on_face(fitting[0], poses[0]), face)
    on_scans = cached(fit_markers_to_scans, frames=fitting, poses=poses, shapes=shapes, config=config.registration)
    return seen, fitting, on_scans


def choose_template(
    asked: Scan | Literal["scan"] | None, on_neutral: Registration, placed: PlacedScans, face: BundledFace,
    config: ScansConfig, cached: StepCache,
) -> ScanTemplate:  # fmt: skip
    """The template, on the neutral scan."""
    bundled = make_template(on_neutral.mesh, face)
    neutral = placed.scans[0].mesh
    if asked is None:
        return bundled
    if isinstance(asked, str):
        return own_template(manifold_part(neutral), bundled)
    on_other = cached(register_scan, scan=asked, config=config.fit)
    mesh = asked.mesh.with_vertices(on_other.T_face_scan.apply(asked.mesh.vertices))
    on_coarse = on_neutral.mesh.vertices[: len(on_other.mesh.vertices)]
    laid = transfer_topology(mesh, on_other.mesh, on_other.mesh.with_vertices(on_coarse), Surface(neutral))
    return own_template(laid, bundled)


@dataclass(frozen=True)
class CoarselyCorresponded:
    """Scans in one topology after the large-scale step."""

    placed: PlacedScans
    template: ScanTemplate
    attachment: Attachment
    covered: Bool[np.ndarray, "scans markers"]
    skin: Float[np.ndarray, "scans n 3"]


def correspond_coarsely(
    template: ScanTemplate, placed: PlacedScans, config: LargeScaleConfig, cached: StepCache
) -> CoarselyCorresponded:
    """Sec. 6.1, eq. 7. The neutral scan has the template on it already."""
    neutral, points = placed.scans[0], placed.skin_points
    attachment = template.attachment_of(template.skin.vertices, points[0])
    seen = np.stack([on.covered for on in placed.on_scans.scans])
    covered, inputs = seen & seen[0], []
    for i, scan in enumerate(placed.scans[1:], 1):
        target = LargeScaleTarget(
            mesh=scan.mesh,
            skin_points=points[i],
            covered=covered[i],
            landmarks=both_landmarks(neutral, scan),
        )
        inputs.append({"template": template, "attachment": attachment, "target": target, "config": config})
    others = cached.each("scans to one topology", large_scale.register, inputs)
    skin = np.stack([template.skin.vertices, *others])
    return CoarselyCorresponded(placed, template, attachment, covered, skin)


def hold_heads_still(coarse: CoarselyCorresponded, config: StillSkinConfig, cached: StepCache) -> CoarselyCorresponded:
    """All scans, with the markers of their frames, in the head pose that their still skin shows."""
    settled = cached(
        settle_heads,
        template=coarse.template,
        shapes=coarse.skin,
        neutral=coarse.placed.scans[0].mesh,
        config=config,
    )
    placed = coarse.placed.moved(settled)
    skin = moved_shapes(settled, coarse.skin)
    return replace(coarse, placed=placed, skin=skin)


def correspond_finely(
    coarse: CoarselyCorresponded, config: FineConfig, constraints: Sequence[NamedConstraint], cached: StepCache
) -> Corresponded:
    """Sec. 6.2, eq. 8-11; where a user's constraints touch scans, those are aligned again and the rest stays."""
    template, scans = coarse.template, coarse.placed.scans
    inputs = {
        "shapes": coarse.skin,
        "faces": template.skin.faces,
        "regions": {name: template.regions[name] for name in FINE_REGIONS},
        "scans": [scan.mesh for scan in scans],
        "weight": template.fine_weight,
        "config": config,
    }
    fine = cached(register_fine, **inputs)
    if constraints:
        by_hand = place_constraints(constraints, [s.name for s in scans], [s.T_face_scan for s in scans])
        again = touched(by_hand, fine.neighbours)
        fine = cached(register_fine, **inputs, constraints=by_hand, only=again, start=fine.vertices)
    return Corresponded(coarse.placed, template, coarse.attachment, coarse.covered, coarse.skin, fine)


def build_rig(found: Corresponded, on_neutral: Registration, config: ScansConfig) -> RegisteredScans:
    """Sec. 7: scans that meet the markers of their frames exactly, as a rig."""
    template, placed, covered = found.template, found.placed, found.covered
    shapes, goals = found.fine.vertices, placed.markers
    attachment = consensus_attachment(template, shapes, placed.skin_points, covered)
    standoff = consensus_standoff(template, shapes, attachment, goals, covered, placed.on_scans.standoff)
    met = meet_markers(template.skin, shapes, attachment, goals, standoff, covered, config.reconstruct)
    skin = lean_on_markers(template, met, attachment, config.lean)
    meshes = [scan.mesh for scan in placed.scans]
    names = [scan.name for scan in placed.scans]
    colours = rig_colours(template, shapes, meshes)
    scan_rig = ScanRig(
        rig=rig_of_scans(template, skin, names, colours),
        resting=placed.scans[0].name,
        labels=placed.take.labels,
        attachment=Attachment(template.skin_faces[attachment.faces], attachment.barycentric),
        standoff=standoff,
        expressions=goals,
        on_skin=covered.mean(axis=0) > COVERED_SHARE,
    )
    return RegisteredScans(
        scan_rig=scan_rig,
        scans=placed.scans,
        on_scans=placed.on_scans,
        template=template,
        attachment=attachment,
        covered=covered,
        coarse=found.coarse,
        fine=found.fine,
        skin=skin,
        unit=on_neutral.landmarks.unit,
        left_out=placed.take.left_out,
    )
