"""Markers meet the face: from unnamed points to a person, an attachment and a figure for how sure that is."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from ..faces.bundled import BundledFace
from ..fitting.marker_identity import IdentityFit, fit_identity, on_closest, on_skin
from ..fitting.template_parts import TemplateParts
from ..fitting.terms import surface_points
from ..mesh import Attachment
from ..progress import SILENT, Progress
from ..register import procrustes
from ..rig import Rig
from ..takes.frame_solve import FrameSolve
from ..takes.stabilise import calm_frames, mean_cloud
from ..transforms import Transform
from .lay_on_face import LayConfig, Trial, lay_on_face, solve_trial, trial_frames, try_alignment
from .neutral import FindNeutralConfig, Neutral, find_neutral
from .plausibility import PlausibilityConfig, refuse_no_face, why_no_face
from .refine_attachment import RefineConfig, refine_attachment


@dataclass(frozen=True)
class CalibrateConfig:
    """How the markers are laid on the face."""

    lay: LayConfig = LayConfig()
    refine: RefineConfig = RefineConfig()
    neutral: FindNeutralConfig = FindNeutralConfig()
    plausibility: PlausibilityConfig = PlausibilityConfig()
    rounds: int = 2
    """Rounds of: attachments from the motion, identity from the attachments."""


@dataclass(frozen=True)
class Calibration:
    """Markers on a person."""

    rig: Rig
    """The person, with expression shapes."""
    attachment: Attachment
    """On the rig's neutral mesh."""
    standoff: Float[np.ndarray, " markers"]
    """Distance of each marker's centre from the skin, mm."""
    T_face_head: Transform
    """Rigid: the take's head frame -> face space."""
    neutral_markers: Float[np.ndarray, "markers 3"]
    """The calm frame's markers in face space, mm: where they are when all weights are 0."""
    neutral: Neutral
    """The frame taken as neutral, and how neutral it is."""
    alignment_margin: float
    """0..1: 1 - (residual of this alignment / residual of the best different one); 0 is a coin's toss."""
    second_best_mm: float
    """Residual of that other alignment, mm; inf where none was found."""
    residual_mm: float
    """rms residual of this one on the trial frames, mm."""
    shape_mm: float
    """rms distance of the calm frame's markers from the best person's face, mm."""
    kept: Int[np.ndarray, " markers"]
    """Which of the take's markers these are: the others are worn off the face."""
    unproven: bool = False
    """By shape or motion they are no face's; markers left out have the last word."""


def calibrate(
    positions: Float[np.ndarray, "frames markers 3"],
    face: BundledFace,
    metric: Float[np.ndarray, "3 3"] | None = None,
    config: CalibrateConfig = CalibrateConfig(),
    progress: Progress = SILENT,
) -> Calibration:
    """Lay a stabilised take (head frame, mm, NaN = gap) on the bundled face with no hint of names or places.

    Geometry proposes, motion decides: alignments of the calm frame with the face's surface are ranked by how well
    the person's shapes then explain the take. Markers that are worn off the face (a head band, a rigid body) are left
    out. The best alignment is refined by sliding markers to where the surface moves as they do.

    Raises:
        BadInput: no alignment brings the markers near a face.
    """
    region = np.flatnonzero((face.regions["face"] > 0.5)[face.rig.neutral.faces].all(axis=1))
    laid = lay_on_face(positions, face, region, metric, config.lay, progress)
    positions = positions[:, laid.kept]
    judged = laid.fit(positions)
    refuse_no_face(judged, config.plausibility)
    person = face.person(laid.identity.coefficients)
    frames = trial_frames(len(positions), config.lay)
    neutral = find_neutral(positions, frames, person, laid.identity, metric, config.lay.trial, config.neutral)
    cloud = mean_cloud(positions, neutral.frame)
    best = try_alignment(
        positions[frames], cloud, face, region, laid.identity.T_face_head, metric, config.lay.trial, config.lay.identity
    )
    fit, solved = _refine(positions[frames], cloud, face, region, best, metric, config, progress)
    return Calibration(
        rig=face.person(fit.coefficients),
        attachment=fit.attachment,
        standoff=np.full(positions.shape[1], fit.standoff_mm),
        T_face_head=fit.T_face_head,
        neutral_markers=fit.T_face_head.apply(cloud),
        neutral=neutral,
        alignment_margin=laid.margin,
        second_best_mm=laid.second_best_mm,
        residual_mm=float(np.sqrt(np.nanmean(solved.residuals**2))),
        shape_mm=laid.shape_mm,
        kept=laid.kept,
        unproven=bool(why_no_face(judged, config.plausibility)),
    )


def calibrate_by_hand(
    positions: Float[np.ndarray, "frames markers 3"],
    face: BundledFace,
    attachment: Attachment,
    metric: Float[np.ndarray, "3 3"] | None = None,
    config: CalibrateConfig = CalibrateConfig(),
) -> Calibration:
    """As `calibrate`, the places given: only person, pose and stand-off are found."""
    cloud = mean_cloud(positions, calm_frames(positions)[0])
    start = procrustes(cloud, surface_points(face.rig.neutral, attachment, config.lay.identity.standoff_mm)).transform
    held = replace(config.lay.identity, slide_mm=(2.0, 2.0))
    first = fit_identity(cloud, face, attachment.faces, start, attachment, config=held)
    frames = trial_frames(len(positions), config.lay)
    person = face.person(first.coefficients)
    neutral = find_neutral(positions, frames, person, first, metric, config.lay.trial, config.neutral)
    cloud = mean_cloud(positions, neutral.frame)
    fit = fit_identity(cloud, face, attachment.faces, first.T_face_head, attachment, config=held)
    solved = solve_trial(positions[frames], cloud, face.person(fit.coefficients), fit, metric, config.lay.trial)
    return Calibration(
        rig=face.person(fit.coefficients),
        attachment=fit.attachment,
        standoff=np.full(positions.shape[1], fit.standoff_mm),
        T_face_head=fit.T_face_head,
        neutral_markers=fit.T_face_head.apply(cloud),
        neutral=neutral,
        alignment_margin=1.0,
        second_best_mm=np.inf,
        residual_mm=float(np.sqrt(np.nanmean(solved.residuals**2))),
        shape_mm=float(np.sqrt(np.mean(fit.residuals**2))),
        kept=np.arange(positions.shape[1]),
    )


def _refine(positions, cloud, face, region, trial: Trial, metric, config, progress) -> tuple[IdentityFit, FrameSolve]:
    """Slide the markers to where the skin moves as they do, then refit the person to the new places."""
    fit, solved = trial.identity, trial.solved
    for number in range(config.rounds):
        rig = face.person(fit.coefficients)
        T_head_face = solved.T_lab_face
        targets = T_head_face.inverse().apply(positions)
        rest = fit.T_face_head.apply(cloud)
        held = refine_attachment(rig, fit, region, solved.weights, targets, solved.used, rest, config.refine)
        firm = replace(config.lay.identity, slide_mm=(2.0, 2.0), rounds=4)
        fit = fit_identity(cloud, face, region, fit.T_face_head, held, fit.coefficients, config=firm)
        solved = solve_trial(positions, cloud, face.person(fit.coefficients), fit, metric, config.lay.trial)
        progress.update("placing the markers", number + 1, config.rounds)
    fit = on_closest(fit, cloud, region)
    fit = on_skin(fit, cloud, TemplateParts(face).skin_faces, config.lay.off_face.suspect_mm)
    return fit, solve_trial(positions, cloud, face.person(fit.coefficients), fit, metric, config.lay.trial)
