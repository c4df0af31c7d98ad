"""Markers meet the face: from unnamed points to a person, an attachment and a figure for how sure that is."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..fitting.marker_identity import IdentityConfig, IdentityFit, fit_identity, on_closest, surface_points
from ..mesh import Attachment, ClosestPoint, Mesh, submesh, vertex_normals
from ..progress import SILENT, Progress
from ..register import procrustes
from ..register.align import AlignConfig, align
from ..rig import Rig
from ..takes.frame_solve import FrameSolve, SolveConfig, solve_frames
from ..takes.stabilise import calm_frames, mean_cloud
from ..transforms import Transform
from .neutral import FindNeutralConfig, Neutral, find_neutral, neutral_model
from .plausibility import Fit, PlausibilityConfig, motion_of, refuse_no_face
from .refine_attachment import RefineConfig, refine_attachment


@dataclass(frozen=True)
class CalibrateConfig:
    """How the markers are laid on the face."""

    align: AlignConfig = AlignConfig()
    identity: IdentityConfig = IdentityConfig()
    refine: RefineConfig = RefineConfig()
    trial: SolveConfig = field(default_factory=lambda: SolveConfig(rounds=2, smoothness=0.0, outlier=np.inf))
    """The short solve by which alignments are told apart."""
    neutral: FindNeutralConfig = FindNeutralConfig()
    plausibility: PlausibilityConfig = PlausibilityConfig()
    trial_frames: int = 120
    """Frames of the take that each alignment must explain."""
    trial_rounds: int = 6
    """... and rounds that its identity fit gets."""
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


def calibrate(
    positions: Float[np.ndarray, "frames markers 3"],
    face: BundledFace,
    metric: Float[np.ndarray, "3 3"] | None = None,
    config: CalibrateConfig = CalibrateConfig(),
    progress: Progress = SILENT,
) -> Calibration:
    """Lay a stabilised take (head frame, mm, NaN = gap) on the bundled face with no hint of names or places.

    Geometry proposes, motion decides: alignments of the calm frame with the face's surface are ranked by how well
    the person's shapes then explain the take. The best one is refined by sliding markers to where the surface moves
    as they do.

    Raises:
        BadInput: no alignment brings the markers near a face.
    """
    region = np.flatnonzero((face.regions["face"] > 0.5)[face.rig.neutral.faces].all(axis=1))
    cloud = mean_cloud(positions, calm_frames(positions)[0])
    surface = ClosestPoint(submesh(_lifted(face.rig.neutral, config.identity.standoff_mm), region)[0])
    candidates = align(cloud, surface, config.align)
    if not candidates:
        raise BadInput("no alignment brings the markers near a face")
    frames = np.linspace(0, len(positions) - 1, min(config.trial_frames, len(positions))).astype(int)
    brief = replace(config.identity, rounds=config.trial_rounds)
    trials = []
    for number, candidate in enumerate(candidates):
        trials.append(_try(positions[frames], cloud, face, region, candidate.T_face_head, metric, config, brief))
        progress.update("trying alignments", number + 1, len(candidates))
    trials.sort(key=lambda trial: trial[0])
    cost, other = trials[0][0], _second_best(trials, cloud, config.align.distinct_mm)
    best = trials[0]
    margin = 1.0 if np.isinf(other) else 1 - cost / other
    shape = float(np.sqrt(np.mean(best[1].residuals ** 2)))
    left = float(np.sqrt(np.nanmean(best[2].residuals ** 2)))
    refuse_no_face(Fit(shape, motion_of(positions), left, float(margin)), config.plausibility)
    person = face.person(best[1].coefficients)
    neutral = find_neutral(positions, frames, person, best[1], metric, config.trial, config.neutral)
    cloud = mean_cloud(positions, neutral.frame)
    best = _try(positions[frames], cloud, face, region, best[1].T_face_head, metric, config, config.identity)
    fit, solved = _refine(positions[frames], cloud, face, region, best, metric, config, progress)
    standoff = np.full(positions.shape[1], fit.standoff_mm)
    residual = float(np.sqrt(np.nanmean(solved.residuals**2)))
    return Calibration(
        rig=face.person(fit.coefficients),
        attachment=fit.attachment,
        standoff=standoff,
        T_face_head=fit.T_face_head,
        neutral_markers=fit.T_face_head.apply(cloud),
        neutral=neutral,
        alignment_margin=float(margin),
        second_best_mm=other,
        residual_mm=residual,
        shape_mm=shape,
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
    start = procrustes(cloud, surface_points(face.rig.neutral, attachment, config.identity.standoff_mm)).transform
    held = replace(config.identity, slide_mm=(2.0, 2.0))
    first = fit_identity(cloud, face, attachment.faces, start, attachment, config=held)
    frames = np.linspace(0, len(positions) - 1, min(config.trial_frames, len(positions))).astype(int)
    person = face.person(first.coefficients)
    neutral = find_neutral(positions, frames, person, first, metric, config.trial, config.neutral)
    cloud = mean_cloud(positions, neutral.frame)
    fit = fit_identity(cloud, face, attachment.faces, first.T_face_head, attachment, config=held)
    solved = _solve(positions[frames], cloud, face.person(fit.coefficients), fit, metric, config.trial)
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
    )


def _try(
    positions, cloud, face, region, T_face_head, metric, config, identity
) -> tuple[float, IdentityFit, FrameSolve]:
    """Fit the person under one alignment and see how much of the take the shapes explain.

    The cost is the rms of what is left, of the calm frame's shape and of the motion together, mm.
    """
    fit = fit_identity(cloud, face, region, T_face_head, config=identity)
    solved = _solve(positions, cloud, face.rig, fit, metric, config.trial)
    squared = np.nanmean(solved.residuals**2) + np.mean(fit.residuals**2)
    return float(np.sqrt(squared)), fit, solved


def _second_best(trials: list, cloud: np.ndarray, distinct_mm: float) -> float:
    """Residual of the best trial that lays the markers elsewhere than the first does, mm."""
    places = [fit.T_face_head.apply(cloud) for _, fit, _ in trials]
    apart = [np.linalg.norm(place - places[0], axis=1).mean() for place in places]
    return min((cost for (cost, _, _), far in zip(trials, apart, strict=True) if far > distinct_mm), default=np.inf)


def _refine(positions, cloud, face, region, trial, metric, config, progress) -> tuple[IdentityFit, FrameSolve]:
    """Slide the markers to where the skin moves as they do, then refit the person to the new places."""
    _, fit, solved = trial
    for number in range(config.rounds):
        rig = face.person(fit.coefficients)
        T_head_face = solved.T_lab_face
        targets = T_head_face.inverse().apply(positions)
        rest = fit.T_face_head.apply(cloud)
        held = refine_attachment(rig, fit, region, solved.weights, targets, solved.used, rest, config.refine)
        firm = replace(config.identity, slide_mm=(2.0, 2.0), rounds=4)
        fit = fit_identity(cloud, face, region, fit.T_face_head, held, fit.coefficients, config=firm)
        solved = _solve(positions, cloud, face.person(fit.coefficients), fit, metric, config.trial)
        progress.update("placing the markers", number + 1, config.rounds)
    fit = on_closest(fit, cloud, region)
    return fit, _solve(positions, cloud, face.person(fit.coefficients), fit, metric, config.trial)


def _solve(positions, cloud, rig, fit, metric, config) -> FrameSolve:
    """Solve the trial frames with the calm frame's own markers at rest: what identity misses is no expression."""
    model = neutral_model(rig, fit, cloud)
    T_head_face = Transform.identity(len(positions)) @ fit.T_face_head.inverse()
    return solve_frames(model, positions, T_head_face, 30.0, metric, config)


def _lifted(mesh: Mesh, distance: float) -> Mesh:
    return mesh.with_vertices(mesh.vertices + distance * vertex_normals(mesh.vertices, mesh.faces))
