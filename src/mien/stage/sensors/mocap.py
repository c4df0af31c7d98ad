"""Optical motion capture of a performer: markers glued on, a head that moves, and the faults of real takes."""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float

from ...clip import Markers
from ...errors import BadInput
from ...mesh import Attachment
from ...transforms import Transform, rotation_from_vector
from ..people.performer import Performer
from ..people.skin import Skin
from ..script.script import smooth
from ..truth import Truth
from .marker_layout import MarkerLayout

SPAN = 512
"""Frames of markers worked on at a time."""


NECK = np.array([0.0, -110.0, 0.0])
"""The point in face space that a head turns about, mm."""


@dataclass(frozen=True)
class HeadMotion:
    """How the head moves while the face does."""

    rotation: float = 0.13
    """Standard deviation of each rotation angle about the neck, radians; peaks are some 2.5 times that. 0: still."""
    translation: float = 18.0
    """Standard deviation of each coordinate, mm."""
    seconds: float = 0.9
    """Time scale of the motion."""


@dataclass(frozen=True)
class MocapConfig:
    """The stage and the cameras' faults."""

    head: HeadMotion = field(default_factory=HeadMotion)
    jitter: float = 0.1
    """Standard deviation of each coordinate's noise, mm. 0: none."""
    dropouts: float = 0.02
    """Share of samples that are missing, in bursts. 0: none."""
    burst: float = 0.08
    """Mean length of a burst, seconds."""
    standoff: tuple[float, float] = (1.5, 3.5)
    """The take's stand-off of marker centres from the skin is drawn from this range, mm. (0, 0): on the skin."""
    standoff_sd: float = 0.25
    """Standard deviation of one marker's stand-off from the take's, mm."""
    lost: int = 0
    """Markers that fall off or lose their label: missing from a random moment to the end or for a long while."""
    swaps: int = 0
    """Times that two neighbouring markers wear each other's label for a while."""
    ghosts: int = 0
    """Times that a label jumps to a false point 15-60 mm away for a few frames."""
    unlabelled: int = 0
    """False trajectories beside the labelled ones, called `*1` and so on: reflections, markers nobody named."""
    up: str = "+Y"
    """The lab's up axis: +X, +Y or +Z."""
    tilt: bool = True
    """False keeps the lab's axes parallel to the resting head's, apart from `up`."""


HARD_MOCAP = MocapConfig(dropouts=0.03, lost=2, swaps=3, ghosts=6, unlabelled=3)
"""What a take is like before anybody has cleaned it."""


@dataclass(frozen=True)
class StagedTake:
    """A take and the truth behind it."""

    markers: Markers
    """The only thing that a solver may see."""
    truth: Truth


def perform(
    actor: Performer | Skin,
    weights: Float[np.ndarray, "frames shapes"],
    rate: float,
    layout: MarkerLayout,
    config: MocapConfig | None = None,
    seed: int = 0,
) -> StagedTake:
    """Play `weights` and record the markers of `layout`; the same seed gives the same take.

    Raises:
        BadInput: weights of the wrong width, shares outside 0..1, an unknown up axis, more losses than markers.
    """
    config = config or MocapConfig()
    _check(actor, weights, layout, config)
    rng = np.random.default_rng([seed, 5])
    T_lab_face = lab_pose(config, rng) @ head_motion(len(weights), rate, config.head, rng)
    k = len(layout.attachment.faces)
    base = rng.uniform(*config.standoff)
    standoff = np.maximum(base + config.standoff_sd * rng.normal(size=k), 0.0) * (base > 0)
    clean = T_lab_face.apply(markers_on_skin(actor, weights, layout.attachment, standoff))
    positions = with_faults(clean, rate, config, rng)
    truth = Truth(actor, weights, T_lab_face, rate, layout.attachment, standoff, clean)
    extra = stray_trajectories(clean, rate, config.unlabelled, rng)
    labels = (*layout.labels, *(f"*{i + 1}" for i in range(config.unlabelled)))
    return StagedTake(Markers(np.concatenate([positions, extra], axis=1), labels, rate), truth)


def _check(actor: Performer | Skin, weights: np.ndarray, layout: MarkerLayout, config: MocapConfig) -> None:
    if weights.shape[1] != len(actor.names):
        raise BadInput(f"weights: expected {len(actor.names)} a frame, one a unit, got {weights.shape[1]}")
    if not 0 <= config.dropouts < 1:
        raise BadInput(f"dropouts: expected a share in 0..1, got {config.dropouts}")
    if config.up not in ("+X", "+Y", "+Z"):
        raise BadInput(f"up: expected +X, +Y or +Z, got {config.up}")
    if config.lost > len(layout.labels):
        raise BadInput(f"lost: expected at most {len(layout.labels)}, the number of markers, got {config.lost}")


def markers_on_skin(
    actor: Performer | Skin,
    weights: Float[np.ndarray, "frames shapes"],
    attachment: Attachment,
    standoff: Float[np.ndarray, " markers"],
) -> Float[np.ndarray, "frames markers 3"]:
    """Marker centres in face space, mm: on the skin, then out along its normal by the stand-off."""
    all_faces = actor.neutral.faces
    owner, ring = _rings(all_faces, attachment.faces)
    rows, local = np.unique(all_faces[ring], return_inverse=True)
    faces, corners = local.reshape(-1, 3), np.searchsorted(rows, all_faces[attachment.faces])
    out = np.empty((len(weights), len(corners), 3))
    for start in range(0, len(weights), SPAN):
        points = actor.vertices(weights[start : start + SPAN], rows)
        on_skin = np.einsum("kc,tkcd->tkd", attachment.barycentric, points[:, corners])
        out[start : start + SPAN] = on_skin + standoff[:, None] * _ring_normals(points, faces, owner)
    return out


def _rings(faces: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All faces that touch each triangle: (which marker, which face)."""
    corners = sp.csr_matrix((np.ones(faces.size), faces.ravel(), np.arange(0, faces.size + 1, 3)))
    touches = sp.csr_matrix(corners[triangles] @ corners.T)
    touches.sort_indices()
    return np.repeat(np.arange(len(triangles)), np.diff(touches.indptr)), touches.indices


def _ring_normals(points: np.ndarray, faces: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Area-weighted mean normal round each marker (t, k, 3) from the faces that each owns."""
    a, b, c = (points[:, faces[:, i]] for i in range(3))
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    total = np.add.reduceat(np.cross(b - a, c - a), starts, axis=1)
    return total / np.linalg.norm(total, axis=2, keepdims=True)


def head_motion(frames: int, rate: float, motion: HeadMotion, rng: np.random.Generator) -> Transform:
    """A smooth random head: rotations about a point in the neck 110 mm below the face's origin, and a sway."""
    sigma = motion.seconds * rate / 2
    curves = smooth(rng.normal(size=(frames + int(8 * sigma), 6)), sigma)[int(4 * sigma) :][:frames]
    curves /= np.maximum(curves.std(axis=0), 1e-9)
    size = np.array([0.7, 1.2, 0.5]) * motion.rotation
    R = rotation_from_vector(np.clip(curves[:, :3], -2.5, 2.5) * size)
    return Transform(R, NECK - R @ NECK + np.clip(curves[:, 3:], -2.5, 2.5) * motion.translation)


def lab_pose(config: MocapConfig, rng: np.random.Generator) -> Transform:
    """Where the resting head is in the lab: somewhere within reach, turned any way about the up axis."""
    up_turn = {"+Y": np.zeros(3), "+Z": np.array([np.pi / 2, 0, 0]), "+X": np.array([0, 0, -np.pi / 2])}[config.up]
    yaw = rng.uniform(-np.pi, np.pi) if config.tilt else 0.0
    lean = rng.normal(size=3) * 0.05 if config.tilt else np.zeros(3)
    R = rotation_from_vector(up_turn) @ rotation_from_vector(np.array([0, yaw, 0])) @ rotation_from_vector(lean)
    where = rotation_from_vector(up_turn) @ np.array([rng.uniform(-800, 800), 1350.0, rng.uniform(-800, 800)])
    return Transform(R, where)


def with_faults(
    clean: Float[np.ndarray, "frames markers 3"], rate: float, config: MocapConfig, rng: np.random.Generator
) -> Float[np.ndarray, "frames markers 3"]:
    """Jitter, swapped labels, ghosts, bursts of drop-outs, lost labels: what the cameras deliver; NaN in gaps."""
    t, k, _ = clean.shape
    out = clean + config.jitter * rng.normal(size=clean.shape)
    for _ in range(config.swaps):
        _swap(out, clean, rate, rng)
    for _ in range(config.ghosts):
        a, marker = rng.integers(t), rng.integers(k)
        away = rng.normal(size=3)
        out[a : a + rng.integers(1, 6), marker] += away / np.linalg.norm(away) * rng.uniform(15, 60)
    out[bursts(t, k, config.dropouts, config.burst * rate, rng)] = np.nan
    for marker in rng.permutation(k)[: config.lost]:
        a = int(t * rng.uniform(0.1, 0.7))
        out[a : a + int(t * rng.uniform(0.25, 0.9)), marker] = np.nan
    return out


def stray_trajectories(
    clean: Float[np.ndarray, "frames markers 3"], rate: float, count: int, rng: np.random.Generator
) -> Float[np.ndarray, "frames strays 3"]:
    """Trajectories of nothing on the face: 0.3 to 3 s each, centimetres off a marker, half of them standing still."""
    t, k, _ = clean.shape
    out = np.full((t, count, 3), np.nan)
    for i in range(count):
        first, length = rng.integers(t), int(rate * rng.uniform(0.3, 3.0))
        span, away = slice(first, first + length), rng.normal(size=3)
        own = clean[span, rng.integers(k)]
        own = np.broadcast_to(own[:1], own.shape) if i % 2 else own
        out[span, i] = own + away / np.linalg.norm(away) * rng.uniform(20, 90)
    return out


def _swap(out: np.ndarray, clean: np.ndarray, rate: float, rng: np.random.Generator) -> None:
    """Two neighbours exchange labels for 0.2 to 1.5 s."""
    t, k, _ = out.shape
    a, marker = rng.integers(t), rng.integers(k)
    distance = np.linalg.norm(clean[a] - clean[a, marker], axis=1)
    other = int(np.argsort(distance)[1])
    span = slice(a, a + int(rate * rng.uniform(0.2, 1.5)))
    out[span, [marker, other]] = out[span, [other, marker]]


def bursts(
    frames: int, markers: int, share: float, length: float, rng: np.random.Generator
) -> Bool[np.ndarray, "frames markers"]:
    """A mask that is true for about `share` of the samples, in runs of mean `length` frames (a two-state chain)."""
    if share <= 0:
        return np.zeros((frames, markers), dtype=bool)
    end = 1.0 / max(length, 1.0)
    begin = end * share / (1 - share)
    away = np.empty((frames, markers), dtype=bool)
    state, dice = rng.random(markers) < share, rng.random((frames, markers))
    for i in range(frames):
        state = np.where(state, dice[i] >= end, dice[i] < begin)
        away[i] = state
    return away
