"""How a cloud of unnamed markers lies on a face, and which of them are worn off it."""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from ..errors import BadInput
from ..faces.bundled import BundledFace
from ..fitting.marker_identity import IdentityConfig, IdentityFit, fit_identity, on_closest, on_skin
from ..mesh import ClosestPoint, Mesh, submesh, vertex_normals
from ..progress import SILENT, Progress
from ..register.align import AlignConfig, align
from ..rig import Rig
from ..takes.frame_solve import FrameSolve, SolveConfig, solve_frames
from ..takes.stabilise import calm_frames, mean_cloud
from ..transforms import Transform
from .neutral import neutral_model
from .plausibility import Fit, motion_of

TRIAL_RATE = 30.0
"""Frames a second that trial frames are said to have; nothing in a trial depends on it."""
OTHER_WAY_MM = 40.0
"""Alignments that lay the markers so far apart, in the mean, lay them another way round; nearer ones slide."""


@dataclass(frozen=True)
class OffFaceConfig:
    """When a marker is worn off the face: on a head band, a cap, a rigid body, a clip at the ear."""

    suspect_mm: float = 6.0
    """Markers are looked for off the face where one lies so far from the best person's; inf: all are on it."""
    most: float = 0.34
    """Share of the markers that may be off it."""
    pulls: tuple[float, ...] = (0.85, 0.7, 0.6)
    """Shares of the markers, the closest ones, that pull while the face is looked for: each gives alignments to try."""
    fade_mm: float = 5.0
    """A marker so far from the face counts a quarter."""
    least_mm: float = 8.0
    """A marker is off the face this far from it ..."""
    times: float = 4.0
    """... and so many times the middle marker's distance."""
    rounds: int = 3
    """Rounds of: the face under those on it, those on it by the face."""
    refit_rounds: int = 3
    """Rounds of closest points and least squares in each of these."""
    fewest: int = 6
    """Markers that must be left."""


@dataclass(frozen=True)
class LayConfig:
    """How alignments are tried."""

    align: AlignConfig = AlignConfig()
    identity: IdentityConfig = IdentityConfig()
    trial: SolveConfig = field(default_factory=lambda: SolveConfig(rounds=2, smoothness=0.0, ridge=1.0, outlier=np.inf))
    """The short solve by which alignments and neutrals are told apart; a dear ridge hides the weights that tell."""
    off_face: OffFaceConfig = OffFaceConfig()
    frames: int = 120
    """Frames of the take that each alignment must explain."""
    clear_margin: float = 0.15
    """An alignment that is better than all others by less than this share is looked for in other calm frames too ..."""
    calm: int = 3
    """... so many in all."""
    rounds: int = 6
    """... and rounds that its identity fit gets."""


@dataclass(frozen=True)
class Trial:
    """One alignment, the person under it, and how much of the take their shapes explain."""

    identity: IdentityFit
    solved: FrameSolve
    kept: Int[np.ndarray, " kept"]
    """Markers on the face."""
    cost_mm: float
    """rms of what is left, of the calm frame's shape and of the motion together; a marker off the face costs what one
    that is just not so would."""


@dataclass(frozen=True)
class Laid:
    """The best alignment."""

    identity: IdentityFit
    kept: Int[np.ndarray, " kept"]
    """Markers on the face."""
    margin: float
    """0..1: 1 - (cost of this alignment / cost of the best different one); 0 is a coin's toss."""
    way_round_margin: float
    """... of the best that lays the markers another way round."""
    second_best_mm: float
    """Cost of that other alignment, mm; inf where none was found."""
    residual_mm: float
    """rms residual on the trial frames, mm."""

    @property
    def shape_mm(self) -> float:
        """rms distance of the calm frame's markers from the best person's face, mm."""
        return float(np.sqrt(np.mean(self.identity.residuals**2)))

    def fit(self, positions: Float[np.ndarray, "frames kept 3"]) -> Fit:
        """What plausibility is judged by."""
        return Fit(
            self.shape_mm, motion_of(positions), self.residual_mm, self.margin, len(self.kept), self.way_round_margin
        )


def lay_on_face(
    positions: Float[np.ndarray, "frames markers 3"],
    face: BundledFace,
    region: Int[np.ndarray, " triangles"],
    metric: Float[np.ndarray, "3 3"] | None = None,
    config: LayConfig = LayConfig(),
    progress: Progress = SILENT,
) -> Laid:
    """The alignment of a stabilised take (head frame, mm) with the face's `region` whose person explains it best.

    Told from the frame that the take dwells at most; where that leaves it unclear, from the first of a few others that
    does not and explains the motion better, since what is held may be an expression.

    Raises:
        BadInput: no alignment brings the markers near a face.
    """
    sample = positions[trial_frames(len(positions), config)]
    first, *others = calm_frames(positions)[: config.calm]
    laid = _lay_cloud(sample, mean_cloud(positions, first), face, region, metric, config, progress)
    if laid.margin >= config.clear_margin:
        return laid
    for frame in others:
        other = _lay_cloud(sample, mean_cloud(positions, frame), face, region, metric, config, progress)
        if other.margin >= config.clear_margin and other.residual_mm < laid.residual_mm:
            return other
    return laid


def _lay_cloud(sample, cloud, face, region, metric, config: LayConfig, progress: Progress) -> Laid:
    """All markers are on the face, unless one of them then lies far from it: then up to a third may be off it, found by
    robust alignment."""
    skin = face.skin_faces
    trials = _trials(sample, cloud, face, region, metric, config, progress)
    laid = seated(_best(trials, cloud, config), cloud, skin, config)
    if laid.identity.residuals.max() < config.off_face.suspect_mm:
        return laid
    robust = _robust_trials(sample, cloud, face, region, metric, config, progress)
    if not robust:
        return laid
    found = seated(_best(robust, cloud, config), cloud, skin, config)
    return found if len(found.kept) < sample.shape[1] and found.shape_mm < laid.shape_mm else laid


def seated(laid: Laid, cloud: np.ndarray, skin: Int[np.ndarray, " triangles"], config: LayConfig) -> Laid:
    """Markers far from the face's region put on the skin where that is nearer: they are worn below the chin."""
    return replace(laid, identity=on_skin(laid.identity, cloud[laid.kept], skin, config.off_face.suspect_mm))


def try_alignment(
    positions: Float[np.ndarray, "frames markers 3"],
    cloud: Float[np.ndarray, "markers 3"],
    face: BundledFace,
    region: Int[np.ndarray, " triangles"],
    T_face_head: Transform,
    metric: Float[np.ndarray, "3 3"] | None,
    trial: SolveConfig,
    identity: IdentityConfig,
) -> Trial:
    """Fit the person under one alignment, all markers on the face, and see how much of the take the shapes explain."""
    fit = fit_identity(cloud, face, region, T_face_head, config=identity)
    solved = solve_trial(positions, cloud, face.rig, fit, metric, trial)
    squared = np.nanmean(solved.residuals**2) + np.mean(fit.residuals**2)
    return Trial(fit, solved, np.arange(len(cloud)), float(np.sqrt(squared)))


def trial_frames(count: int, config: LayConfig) -> Int[np.ndarray, " trial"]:
    """The frames that alignments are tried on."""
    return np.linspace(0, count - 1, min(config.frames, count)).astype(int)


def solve_trial(
    positions: Float[np.ndarray, "frames markers 3"],
    cloud: Float[np.ndarray, "markers 3"],
    rig: Rig,
    fit: IdentityFit,
    metric: Float[np.ndarray, "3 3"] | None,
    config: SolveConfig,
) -> FrameSolve:
    """Solve the trial frames with the calm frame's own markers at rest: what identity misses is no expression."""
    model = neutral_model(rig, fit, cloud)
    T_head_face = Transform.identity(len(positions)) @ fit.T_face_head.inverse()
    return solve_frames(model, positions, T_head_face, TRIAL_RATE, metric, config)


def _trials(positions, cloud, face, region, metric, config: LayConfig, progress: Progress) -> list[Trial]:
    """All distinct alignments tried with every marker on the face, best first."""
    brief = replace(config.identity, rounds=config.rounds)
    candidates = _alignments(cloud, face, region, config, config.align.keep)
    if not candidates:
        raise BadInput("no alignment brings the markers near a face")
    trials = []
    for number, T_face_head in enumerate(candidates):
        trials.append(try_alignment(positions, cloud, face, region, T_face_head, metric, config.trial, brief))
        progress.update("trying alignments", number + 1, len(candidates))
    return sorted(trials, key=lambda trial: trial.cost_mm)


def _robust_trials(positions, cloud, face, region, metric, config: LayConfig, progress: Progress) -> list[Trial]:
    """Alignments of most of the markers, those off the face left out: all by their shape, the best by their motion."""
    brief = replace(config.identity, rounds=config.rounds)
    worn, tried = [], []
    for number, pull in enumerate(config.off_face.pulls):
        for T_face_head in _alignments(cloud, face, region, config, pull):
            placed = T_face_head.apply(cloud)
            if any(np.linalg.norm(placed - other, axis=1).mean() < config.align.distinct_mm for other in tried):
                continue
            tried.append(placed)
            fit, kept = fit_most(cloud, face, region, T_face_head, brief, config.off_face)
            if len(kept) >= max(config.off_face.fewest, (1 - config.off_face.most) * len(cloud)):
                worn.append((_cost(float(np.mean(fit.residuals**2)), kept, cloud, config.off_face), fit, kept))
        progress.update("looking for markers off the face", number + 1, len(config.off_face.pulls))
    worn.sort(key=lambda found: found[0])
    trials = []
    for _, fit, kept in worn[: config.align.most]:
        solved = solve_trial(positions[:, kept], cloud[kept], face.rig, fit, metric, config.trial)
        squared = float(np.nanmean(solved.residuals**2) + np.mean(fit.residuals**2))
        trials.append(Trial(fit, solved, kept, _cost(squared, kept, cloud, config.off_face)))
    return sorted(trials, key=lambda trial: trial.cost_mm)


def _alignments(cloud, face: BundledFace, region, config: LayConfig, keep: float) -> list[Transform]:
    """Distinct alignments by shape, T_face_head, best first."""
    surface = ClosestPoint(submesh(_lifted(face.rig.neutral, config.identity.standoff_mm), region)[0])
    return [found.T_face_head for found in align(cloud, surface, replace(config.align, keep=keep))]


def fit_most(
    cloud: Float[np.ndarray, "markers 3"],
    face: BundledFace,
    region: Int[np.ndarray, " triangles"],
    T_face_head: Transform,
    identity: IdentityConfig,
    config: OffFaceConfig,
) -> tuple[IdentityFit, Int[np.ndarray, " kept"]]:
    """The person under most of the markers, and which these are: robustly at first, then under those alone."""
    fit = fit_identity(cloud, face, region, T_face_head, config=replace(identity, fade_mm=config.fade_mm))
    skin = face.skin_faces
    kept = np.flatnonzero(~off_face(on_skin(fit, cloud, skin, config.suspect_mm).residuals, config))
    again = replace(identity, rounds=config.refit_rounds)
    under = kept
    for _ in range(config.rounds):
        if len(kept) < config.fewest:
            return fit, kept
        fit = fit_identity(cloud[kept], face, region, fit.T_face_head, start=fit.coefficients, config=again)
        apart = on_skin(on_closest(fit, cloud, region), cloud, skin, config.suspect_mm).residuals
        under, kept = kept, np.flatnonzero(~off_face(apart, config))
        if np.array_equal(kept, under):
            break
    return fit, under


def _cost(squared: float, kept: np.ndarray, cloud: np.ndarray, config: OffFaceConfig) -> float:
    """rms over all markers, those off the face as if they were just so, mm."""
    off = len(cloud) - len(kept)
    return float(np.sqrt((len(kept) * squared + off * config.least_mm**2) / len(cloud)))


def off_face(distances: Float[np.ndarray, " markers"], config: OffFaceConfig) -> Bool[np.ndarray, " markers"]:
    """Which markers are too far from the face to be on it."""
    return distances > max(config.least_mm, config.times * float(np.median(distances)))


def _best(trials: list[Trial], cloud: np.ndarray, config: LayConfig) -> Laid:
    """The best trial, and how much better it is than the best that lays the markers elsewhere, or another way round."""
    best = trials[0]
    places = [trial.identity.T_face_head.apply(cloud) for trial in trials]
    apart = np.array([np.linalg.norm(place - places[0], axis=1).mean() for place in places])
    off_face = (len(cloud) - len(best.kept)) * config.off_face.least_mm**2 / len(cloud)
    squared = np.array([trial.cost_mm**2 for trial in trials]) - off_face
    elsewhere, other = margin_over(squared, apart > config.align.distinct_mm)
    way_round, _ = margin_over(squared, apart > OTHER_WAY_MM)
    left = float(np.sqrt(np.nanmean(best.solved.residuals**2)))
    return Laid(best.identity, best.kept, elsewhere, way_round, float(np.sqrt(other + off_face)), left)


def margin_over(squared: Float[np.ndarray, " trials"], others: Bool[np.ndarray, " trials"]) -> tuple[float, float]:
    """How much better the first trial is than the best of some others, 0..1 (1 where there is none), and that one's
    squared cost, by squared costs in mm^2."""
    other = float(np.min(squared[others], initial=np.inf))
    return float(1 - np.sqrt(squared[0] / other)), other


def _lifted(mesh: Mesh, distance: float) -> Mesh:
    return mesh.with_vertices(mesh.vertices + distance * vertex_normals(mesh.vertices, mesh.faces))
