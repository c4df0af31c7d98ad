"""A marker take becomes an animated face."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ..clip import Markers
from ..faces.bundled import BundledFace
from ..mesh import Attachment
from ..one_line import one_line
from ..progress import SILENT, Progress
from ..rig import Performance, Rig
from ..takes.depth_reliability import DepthConfig, depth_metric
from ..takes.face_cluster import FaceClusterConfig, FaceMarkers, find_face, named_markers
from ..takes.frame_solve import FrameSolve, SolveConfig, solve_frames
from ..takes.gaps import GapConfig, fill_gaps
from ..takes.marker_model import marker_model
from ..takes.motion_covariance import motion_covariance
from ..takes.outliers import Cleaned, OutlierConfig, remove_outliers
from ..takes.stabilise import StabiliseConfig, stabilise
from ..takes.world import turn_y_up
from ..transforms import Transform
from .between_markers import BetweenConfig, carry_between_markers
from .calibrate import CalibrateConfig, Calibration, calibrate, calibrate_by_hand
from .left_out import LeftOutConfig, LeftOutError, leave_markers_out, left_out_doubt, neutral_leaves_open
from .personalise_shapes import PersonaliseConfig, personalise_shapes, shape_corrections, spline
from .plausibility import Fit, doubts, refuse_untold
from .region_confidence import RegionConfidence, region_confidence, regions_line

WARM_ROUNDS = 2
"""Gauss-Newton rounds of a solve that starts from the one before the shapes were bent."""


@dataclass(frozen=True)
class TakeConfig:
    """Everything that `mien solve` may be told."""

    face: FaceClusterConfig = FaceClusterConfig()
    outliers: OutlierConfig = OutlierConfig()
    stabilise: StabiliseConfig = StabiliseConfig()
    gaps: GapConfig = GapConfig()
    depth: DepthConfig = DepthConfig()
    calibrate: CalibrateConfig = CalibrateConfig()
    solve: SolveConfig = SolveConfig()
    personalise: PersonaliseConfig = PersonaliseConfig()
    left_out: LeftOutConfig = LeftOutConfig()
    between: BetweenConfig = BetweenConfig()
    personalise_rounds: int = 3
    """Rounds of solving and bending the shapes to the performer; 0 keeps the bundled face's own shapes."""


@dataclass(frozen=True)
class TakeSolve:
    """An animated face and what is known of how good it is."""

    performance: Performance
    markers: Markers
    """The face's markers, wild samples turned to gaps."""
    lines: tuple[str, ...]
    """What was left out, and what is doubtful: a line each."""
    calibration: Calibration
    """Where the markers sit, on the performance's rig."""
    T_lab_face: Transform
    """Head pose in the frame of the take's file; the performance's world has it turned to +Y up."""
    residuals: Float[np.ndarray, "frames markers"]
    """Distance from every marker to the model, mm; NaN where it was not seen."""
    used: Bool[np.ndarray, "frames markers"]
    """Samples that counted."""
    depth_known: bool
    """False where the take's depth is no measurement (tracked with one camera)."""
    left_out: LeftOutError
    """Cross-validated error of the markers on the person before the shapes are bent to them."""
    regions: tuple[RegionConfidence, ...] = ()
    """The same, a region of the face at a time."""

    def __repr__(self) -> str:
        return one_line(self, self.performance, f"mean residual {np.nanmean(self.residuals):.2f} mm")


def solve_take(
    markers: Markers,
    face: BundledFace,
    attachment: Attachment | None = None,
    config: TakeConfig = TakeConfig(),
    progress: Progress = SILENT,
) -> TakeSolve:
    """Markers alone -> a person, their rig bent to them, weights and head pose for every frame.

    The steps: find the face's markers; turn wild samples to gaps; take the head's motion out; fill short gaps; lay
    the markers on the face and find the neutral; solve all frames, bend the shapes to the performer, at the markers
    and then between them, and solve again.

    Args:
        attachment: places the markers by hand, one a marker of the take.

    Raises:
        BadInput: the markers are no face's; too few are seen; those left out by turns are told worse than frozen.
    """
    found = find_face(markers, config.face)
    cleaned = remove_outliers(found.markers, config.outliers)
    rate = markers.rate
    stabilised = stabilise(cleaned.markers, config.stabilise)
    positions = fill_gaps(stabilised.markers.positions, rate, config.gaps)
    depth = depth_metric(cleaned.markers.positions, config.depth)
    if attachment is None:
        calibration = calibrate(positions, face, depth.metric, config.calibrate, progress)
    else:
        here = Attachment(attachment.faces[found.kept], attachment.barycentric[found.kept])
        calibration = calibrate_by_hand(positions, face, here, depth.metric, config.calibrate)
    positions = positions[:, calibration.kept]
    start = stabilised.T_lab_head @ calibration.T_face_head.inverse()
    lab = stabilised.T_lab_head.apply(positions)
    metric = depth.in_face_space(start)
    S = spline(calibration.rig.neutral, calibration.attachment, face.parts["skin"], config.personalise)
    calibration = replace(calibration, rig=fit_neutral_to_markers(calibration, face, S))
    personal, solved = _solve_and_personalise(lab, start, rate, calibration, S, metric, config, progress)
    told = (calibration, personal, solved, metric, depth.known, face, config)
    personal, solved, left_out = carry_between(lab, rate, *told)
    refuse_untold(calibration.shape_mm, left_out, config.calibrate.plausibility, calibration.unproven)
    regions = region_confidence(personal.rig, personal.attachment, face.regions, left_out)
    performance = Performance(
        rig=personal.rig,
        weights=solved.weights,
        T_world_face=turn_y_up(solved.T_lab_face),
        rate=rate,
        tracked=solved.tracked,
    )
    return TakeSolve(
        performance=performance,
        markers=cleaned.markers.only(calibration.kept),
        lines=_lines(found, cleaned, calibration, left_out, regions, config),
        calibration=personal,
        T_lab_face=solved.T_lab_face,
        residuals=solved.residuals,
        used=solved.used,
        depth_known=depth.known,
        left_out=left_out,
        regions=regions,
    )


def _lines(
    found: FaceMarkers, cleaned: Cleaned, calibration: Calibration, left_out: LeftOutError, regions, config: TakeConfig
) -> tuple[str, ...]:
    """What whoever runs the job should know."""
    fit = Fit(calibration.shape_mm, np.inf, 0.0, calibration.alignment_margin)
    markers = cleaned.markers
    lines = [
        *found.lines,
        cleaned.line(),
        off_face_line(markers.labels, calibration.kept),
        calibration.neutral.line(markers.rate),
        *doubts(fit, config.calibrate.plausibility),
        *left_out_doubt(left_out, config.left_out),
        regions_line(regions),
    ]
    return tuple(line for line in lines if line)


def off_face_line(labels: tuple[str, ...], kept: Int[np.ndarray, " kept"]) -> str:
    """Which markers are worn off the face; empty where none is."""
    everyone = np.arange(len(labels))
    off = np.setdiff1d(everyone, kept)
    if not len(off):
        return ""
    named = named_markers(labels, off)
    return f"worn off the face, of use for the head's pose alone: {named}"


def _solve_and_personalise(
    lab, T_lab_face, rate, calibration: Calibration, S: np.ndarray, metric, config: TakeConfig, progress: Progress
) -> tuple[Calibration, FrameSolve]:
    """Solve every frame, bend the shapes by what is left, and again."""
    rounds = config.personalise_rounds
    solving = config.solve
    warm = None
    for number in range(rounds + 1):
        model = marker_model(calibration.rig, calibration.attachment, calibration.standoff)
        solved = solve_frames(model, lab, T_lab_face, rate, metric, solving, warm)
        progress.update("solving frames", number + 1, rounds + 1)
        if number == rounds:
            break
        T_lab_face = solved.T_lab_face
        warm = solved.weights
        solving = replace(config.solve, rounds=WARM_ROUNDS)
        targets = T_lab_face.inverse().apply(lab)
        used = solved.used & solved.tracked[:, None]
        neutral, shapes = shape_corrections(model, solved.weights, targets, used, rate, config.personalise)
        bent = personalise_shapes(calibration.rig, calibration.attachment, neutral, shapes, S, config.personalise)
        calibration = replace(calibration, rig=bent)
    return calibration, solved


def carry_between(
    lab, rate, unbent: Calibration, personal: Calibration, solved: FrameSolve, metric, depth_known, face, config
) -> tuple[Calibration, FrameSolve, LeftOutError]:
    """Bend the shapes between the markers as far as carried motion tells left-out markers better, and solve again."""
    skin, between, covariance = face.parts["skin"], config.between, None
    if depth_known and between.most > 0:
        covariance = motion_covariance(unbent.rig, unbent.attachment, skin, between.motion)
    left_out = leave_markers_out(
        model=marker_model(unbent.rig, unbent.attachment, unbent.standoff),
        positions=lab,
        T_lab_face=solved.T_lab_face,
        metric=metric,
        solve=config.solve,
        config=config.left_out,
        covariance=covariance,
        between=between,
    )
    left_out = replace(left_out, open_share=neutral_leaves_open(unbent.neutral.added, config.left_out))
    if covariance is None or left_out.carry_share == 0:
        return personal, solved, left_out
    rig = carry_between_markers(personal.rig, personal.attachment, covariance, skin, left_out.carry_share, between)
    personal = replace(personal, rig=rig)
    model = marker_model(rig, personal.attachment, personal.standoff)
    again = replace(config.solve, rounds=WARM_ROUNDS)
    solved = solve_frames(model, lab, solved.T_lab_face, rate, metric, again, solved.weights)
    return personal, solved, left_out


def fit_neutral_to_markers(calibration: Calibration, face: BundledFace, S: np.ndarray) -> Rig:
    """The person with the calm frame's markers met by the neutral face, so that no expression has to."""
    model = marker_model(calibration.rig, calibration.attachment, calibration.standoff)
    neutral = calibration.rig.neutral
    missing = calibration.neutral_markers - model.neutral
    vertices = neutral.vertices + S @ missing
    met = neutral.with_vertices(vertices)
    deltas = face.fitted_deltas(vertices)
    return calibration.rig.with_shapes(met, deltas)
