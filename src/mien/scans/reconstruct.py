"""From registered scans and a marker take to the performance (Huang et al. 2011, sec. 7, eq. 12).

Past the paper: what the scans cannot mix is not left at the markers. Its strongest directions become corrective shapes,
spread over the skin as the markers ask for them, so that the performance stays a rig and weights.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.signal import savgol_filter

from ..clip import Markers, visible
from ..errors import BadInput
from ..mesh import Attachment, Mesh
from ..progress import SILENT, Progress
from ..register import procrustes
from ..register.interpolate import green_functions, interpolate_from_points
from ..rig import Performance, Rig
from ..rig.unit_weights import corrective_names
from ..solve import nnls
from ..takes.frame_solve import normal_equations, without_pose
from ..takes.gaps import GapConfig, fill_gaps
from ..takes.marker_model import MarkerModel, normals_at
from ..takes.stabilise import StabiliseConfig, calm_frames, hold, last_tracked, mean_cloud, stabilise
from ..takes.world import turn_y_up
from ..transforms import Transform, rotation_from_vector
from .scan_rig import ScanRig


@dataclass(frozen=True)
class ReconstructConfig:
    """How a take is played on registered scans."""

    stabilise: StabiliseConfig = StabiliseConfig()
    gaps: GapConfig = GapConfig()
    smooth_s: float = 0.08
    """Markers are smoothed by parabolas over so long, seconds; 0: not at all."""
    reach_mm: float = 40.0
    """What a marker asks of the skin fades beyond about so far from it."""
    rounds: int = 3
    """Gauss-Newton rounds of weights and head pose."""
    correctives: int = 20
    """Most corrective shapes that are added for what the scans cannot mix; 0: none, as in the paper."""
    worth_mm: float = 0.03
    """... of which each must move the markers by this much, rms."""
    fewest: int = 6
    """Frames with fewer markers are not tracked."""


def meet_markers(
    mesh: Mesh,
    shapes: Float[np.ndarray, "scans n 3"],
    attachment: Attachment,
    markers: Float[np.ndarray, "scans markers 3"],
    standoff: Float[np.ndarray, " markers"],
    covered: Bool[np.ndarray, "scans markers"],
    config: ReconstructConfig = ReconstructConfig(),
) -> Float[np.ndarray, "scans n 3"]:
    """Registered scans deformed to meet the markers of their frames exactly (sec. 7; Laplacian deformation).

    The displacement is the smoothest one that takes every covered marker's skin point under its marker: least
    |M^(-1/2) L d|^2 + |M^(1/2) d|^2 / reach^4 with D d = what is missing. One factorisation serves all scans: the
    skin's response to each marker is found once.
    """
    D = attachment.matrix(mesh)
    response = green_functions(mesh, D, config.reach_mm)
    out = shapes.copy()
    for i, shape in enumerate(shapes):
        held = covered[i]
        if not held.any():
            continue
        missing = markers[i] - D @ shape - standoff[:, None] * normals_at(D, shape, mesh.faces)
        meets = (D @ response)[np.ix_(held, held)]
        out[i] = shape + response[:, held] @ np.linalg.solve(meets, missing[held])
    return out


@dataclass(frozen=True)
class ScanSolve:
    """A take played on registered scans."""

    performance: Performance
    """The scans' targets first, then correctives."""
    T_lab_face: Transform
    """Head pose in the frame of the take's file."""
    mixed: Float[np.ndarray, "frames markers"]
    """Distance from marker to the mix of scans (eq. 12), mm; NaN where not seen."""
    residuals: Float[np.ndarray, "frames markers"]
    """... and to the whole performance, correctives and all."""
    labels: tuple[str, ...]
    """The markers that take and rig share."""


def solve_on_scans(
    markers: Markers,
    scan_rig: ScanRig,
    config: ReconstructConfig = ReconstructConfig(),
    progress: Progress = SILENT,
) -> ScanSolve:
    """Weights and head pose for every frame of a take, on a rig of scans of the same person with the same markers.

    Raises:
        BadInput: fewer than half of the rig's markers are in the take, or no frame shows enough of them.
    """
    progress.update("solving frames", 0, 3)
    in_take, in_rig = _shared(markers, scan_rig)
    chosen = replace(markers, positions=markers.positions[:, in_take], labels=tuple(scan_rig.labels[i] for i in in_rig))
    stabilised = stabilise(chosen, config.stabilise)
    positions = fill_gaps(stabilised.markers.positions, chosen.rate, config.gaps)
    positions = smoothed(positions, round(config.smooth_s * chosen.rate))
    calm = mean_cloud(positions, calm_frames(positions)[0])
    expressions, on_skin = scan_rig.expressions[:, in_rig], scan_rig.on_skin[in_rig]
    start = stabilised.T_lab_head @ _repeated(procrustes(expressions[0], calm).transform, len(positions))
    solved = solve_weights(expressions, stabilised.T_lab_head.apply(positions), start, config)
    progress.update("solving frames", 1, 3)
    found = correctives(scan_rig, in_rig[on_skin], solved.missing[:, on_skin], config)
    progress.update("solving frames", 2, 3)
    rig, shown = scan_rig.rig, last_tracked(solved.tracked)
    whole = Rig(rig.neutral, np.concatenate([rig.deltas, found.shapes]), (*rig.names, *found.names), rig.texture)
    weights = np.concatenate([solved.weights, found.weights], axis=1)[shown]
    pose = hold(solved.T_lab_face, solved.tracked)
    left, seen = solved.missing.copy(), visible(chosen.positions)
    left[:, on_skin] -= found.explained
    mixed, residuals = (np.where(seen, np.linalg.norm(m, axis=2), np.nan) for m in (solved.missing, left))
    progress.update("solving frames", 3, 3)
    performance = Performance(whole, weights, turn_y_up(pose), markers.rate, solved.tracked)
    return ScanSolve(performance, pose, mixed, residuals, chosen.labels)


def smoothed(positions: Float[np.ndarray, "frames markers 3"], window: int) -> Float[np.ndarray, "frames markers 3"]:
    """Each marker's path by parabolas over `window` frames (Savitzky and Golay 1964); as it is near gaps."""
    window += 1 - window % 2
    if window < 5 or window > len(positions):
        return positions
    quiet = np.asarray(savgol_filter(positions, window, 2, axis=0))
    return np.where(np.isfinite(quiet), quiet, positions)


def _shared(markers: Markers, scan_rig: ScanRig) -> tuple[Int[np.ndarray, " k"], Int[np.ndarray, " l"]]:
    """Columns of the take and of the rig that bear the same label."""
    place = {label: i for i, label in enumerate(markers.labels)}
    in_rig = np.array([i for i, label in enumerate(scan_rig.labels) if label in place], dtype=np.int64)
    if 2 * len(in_rig) < len(scan_rig.labels):
        missing = [label for label in scan_rig.labels if label not in place]
        raise BadInput(
            f"the take has {len(in_rig)} of the rig's {len(scan_rig.labels)} markers (not {', '.join(missing[:4])}, "
            "...); solve takes that were recorded with the markers of the scans' own take"
        )
    return np.array([place[scan_rig.labels[i]] for i in in_rig], dtype=np.int64), in_rig


def _repeated(T: Transform, count: int) -> Transform:
    return Transform(np.broadcast_to(T.rotation, (count, 3, 3)), np.broadcast_to(T.translation, (count, 3)))


@dataclass(frozen=True)
class Correctives:
    """Shapes for what scans cannot mix, over a take."""

    shapes: Float[np.ndarray, "shapes n 3"]
    names: tuple[str, ...]
    weights: Float[np.ndarray, "frames shapes"]
    """Of either sign; unit root mean square over the take."""
    explained: Float[np.ndarray, "frames markers 3"]
    """What they do at the markers, face space, mm."""


def correctives(
    scan_rig: ScanRig,
    which: Int[np.ndarray, " markers"],
    missing: Float[np.ndarray, "frames markers 3"],
    config: ReconstructConfig = ReconstructConfig(),
) -> Correctives:
    """The strongest directions of what is missing at the markers, spread over the skin.

    Args:
        which: the rig's markers that `missing` (face space, mm; NaN where not seen) is of.
    """
    mesh, known = scan_rig.rig.neutral, np.nan_to_num(missing)
    frames, count, _ = known.shape
    left, size, right = np.linalg.svd(known.reshape(frames, 3 * count), full_matrices=False)
    rms = size / np.sqrt(max(frames * count, 1))
    keep = min(int((rms > config.worth_mm).sum()), config.correctives)
    names = corrective_names(keep)
    if keep == 0:
        nothing = np.zeros((0, len(mesh.vertices), 3))
        return Correctives(nothing, names, np.zeros((frames, 0)), np.zeros_like(known))
    place = scan_rig.attachment
    S = interpolate_from_points(mesh, Attachment(place.faces[which], place.barycentric[which]), config.reach_mm)
    unit = (right[:keep] * (size[:keep, None] / np.sqrt(frames))).reshape(keep, count, 3)
    shapes = np.einsum("nm,kmd->knd", S, unit, optimize=True)
    explained = ((left[:, :keep] * size[:keep]) @ right[:keep]).reshape(known.shape)
    return Correctives(shapes, names, left[:, :keep] * np.sqrt(frames), explained)


@dataclass(frozen=True)
class FrameWeights:
    """A take as mixes of scanned expressions."""

    weights: Float[np.ndarray, "frames targets"]
    """w of eq. 12 of all but the resting expression, whose own is what they leave of 1."""
    T_lab_face: Transform
    """Head pose, one a frame."""
    missing: Float[np.ndarray, "frames markers 3"]
    """Marker minus mix, face space, mm; NaN where not seen."""
    tracked: Bool[np.ndarray, " frames"]


def solve_weights(
    expressions: Float[np.ndarray, "scans markers 3"],
    positions: Float[np.ndarray, "frames markers 3"],
    T_lab_face: Transform,
    config: ReconstructConfig = ReconstructConfig(),
) -> FrameWeights:
    """Eq. 12 for every frame: non-negative weights of the scanned expressions, each frame by itself.

    Expressions count from the first, resting one, as in any blendshape rig, so that a mix never grows or shrinks the
    head: x = x_0 + sum_i w_i (x_i - x_0), w_i >= 0. The paper's sum over all expressions is the same where its weights
    add up to 1. The head's pose is found along with the weights (Gauss-Newton; eliminated before the weights are
    solved for).

    Args:
        expressions: markers on the scanned expressions, face space, mm.
        positions: the take, lab frame, mm; NaN where not seen.
        T_lab_face: where the head is, roughly.
    """
    seen, T = visible(positions), T_lab_face
    rest, modes = expressions[0], expressions[1:] - expressions[0]
    jacobian = MarkerModel(rest, modes).jacobian()
    weights = np.zeros((len(positions), len(modes)))
    for _ in range(config.rounds):
        off = np.nan_to_num(T.inverse().apply(positions) - rest)
        gram, linear, back = without_pose(*normal_equations(jacobian, np.eye(3), off, seen))
        weights = nnls(gram, linear, weights).values
        pose = back[:, :, 0] - np.einsum("tpk,tk->tp", back[:, :, 1:], weights)
        T = T @ Transform(rotation_from_vector(pose[:, :3]), pose[:, 3:])
    missing = T.inverse().apply(positions) - rest - np.tensordot(weights, modes, axes=1)
    return FrameWeights(weights, T, missing, seen.sum(axis=1) >= config.fewest)
