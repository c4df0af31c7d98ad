"""Which markers of a take are one face: a body, props and a second actor are left out and named."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..clip import Markers
from ..errors import BadInput
from .outliers import nearest_markers
from .stabilise import stabilise


@dataclass(frozen=True)
class FaceClusterConfig:
    """What holds the markers of a face together."""

    link_mm: float = 80.0
    """Neighbours on a face are nearer than this: seven markers on a face stand about 60 mm apart."""
    link_spacings: float = 4.0
    """... and than so many times the middle distance of nearest neighbours in the group, but half of that at least."""
    bend_mm: float = 15.0
    """... and their distance varies by less (half of its 5th to 95th percentile): a jaw opens, an arm swings away."""
    stray_mm: float = 3.5
    """A marker that usually moves by more than this in the head's frame must go along with a neighbour ..."""
    stray_share: float = 0.9
    """... to within this share of its own motion; else it stands in the room while the head passes."""
    limbs: float = 0.03
    """A body is no face, whatever its unit: a quarter of its markers usually lie this share of its size from their
    middle place, walking people 0.05, a trotting dog 0.09; faces 0.002 to 0.014. Infinity lets all pass."""
    neighbours: int = 4
    """How many neighbours it is compared with."""
    span_mm: tuple[float, float] = (45.0, 330.0)
    """Box diagonal of a face's markers, head band and all."""
    head_mm: float = 620.0
    """... and at most of a group that hangs together: a face, and a rigid body on a cap or helmet."""
    fewest: int = 6
    """Markers that a face needs."""
    most_frames: int = 300
    """Frames that are looked at, spread over the take."""
    least_seen: float = 0.02
    """Markers seen in a smaller share of the frames are left out: there is nothing to solve with."""


@dataclass(frozen=True)
class FaceMarkers:
    """The face of a take."""

    markers: Markers
    """Its markers alone."""
    kept: Int[np.ndarray, " kept"]
    """Which of the take's they are."""
    lines: tuple[str, ...]
    """What was left out and why, a line each; readers tell of labels never seen."""


def find_face(markers: Markers, config: FaceClusterConfig = FaceClusterConfig()) -> FaceMarkers:
    """The largest group of markers that hang together like a face; a take that is one face keeps them all.

    A cloud as large as a face is one. In a larger one, markers are linked where they stay near and at about the same
    distance; of the groups that have a face's size the one with the most markers is taken. A marker that stands in the
    room while the face passes is left out.

    Raises:
        BadInput: not finite rate, fewer than six markers that are seen, no group that could be a face, or a body.
    """
    if not (np.isfinite(markers.rate) and markers.rate > 0):
        raise BadInput(f"the take's rate is {markers.rate}; give frames a second with --rate")
    share = markers.seen.mean(axis=0) if len(markers.positions) else np.zeros(len(markers.labels))
    seen = np.flatnonzero(share >= max(config.least_seen, 1e-9))
    if len(seen) < config.fewest:
        raise BadInput(f"this is no face: {len(seen)} markers are seen; {config.fewest} are needed")
    cloud = markers.positions[:, seen]
    low, high = config.span_mm
    groups = [np.arange(len(seen))] if low <= _span(cloud) <= high else _tightened(cloud, config)
    sizes = [len(g) for g in groups]
    large = [g for g in groups if len(g) >= config.fewest and low <= _span(cloud[:, g]) <= config.head_mm]
    faces = [seen[g] for g in large]
    if not faces:
        raise BadInput(_no_face(markers, seen, sizes, config))
    kept = np.sort(_going_along(markers, faces[0], config))
    return FaceMarkers(markers.only(kept), kept, _lines(markers, share, kept, faces, config))


def _going_along(markers: Markers, group: np.ndarray, config: FaceClusterConfig) -> np.ndarray:
    """The group without markers that stand near the face and do not go along with it.

    Markers of one prop go along with one another: what moves is skin where a chain of neighbours that go along leads
    to a marker that stays with the head.
    """
    head = stabilise(markers.only(group)).markers.positions
    moved = head - np.nanmedian(head, axis=0)
    own = _usual(moved)
    _refuse_body(own, _span(head), config)
    near = nearest_markers(head, config.neighbours)
    beside = np.stack([_usual(moved - moved[:, around]) for around in near.T], axis=1)
    along = beside <= config.stray_share * own[:, None]
    skin = own <= config.stray_mm
    for _ in group:
        skin |= (along & skin[near]).any(axis=1)
    return group[skin] if skin.sum() >= config.fewest else group


def _refuse_body(own: np.ndarray, span: float, config: FaceClusterConfig) -> None:
    """Sizes tell no body from a face where the file names no unit: 172 cm and 172 mm are one number. Motion does."""
    swing = float(np.quantile(own, 0.75))
    if swing > config.limbs * span:
        raise BadInput(
            f"this is no face: a quarter of its {len(own)} markers usually lie {100 * swing / span:.0f} % of its size "
            "or more from their middle place, as limbs do and faces never; if there is a face in it, choose its "
            "markers with --markers PATTERN"
        )


def _usual(moved: np.ndarray) -> np.ndarray:
    """Middle length of every marker's displacement, mm: one ghost makes no stray; NaN frames left out."""
    return np.nan_to_num(np.nanmedian(np.linalg.norm(moved, axis=2), axis=0))


def _tightened(positions: np.ndarray, config: FaceClusterConfig) -> list[np.ndarray]:
    """Groups of linked markers, largest first; where a dense face chains with a shoulder, the link is shortened."""
    groups = _groups(positions, config.link_mm, config)
    place = np.nanmedian(positions[:, groups[0]], axis=0)
    if len(place) < config.fewest:
        return groups
    nearest = np.sort(np.linalg.norm(place[:, None] - place[None], axis=2), axis=1)[:, 1]
    link = np.clip(config.link_spacings * np.median(nearest), config.link_mm / 2, config.link_mm)
    return _groups(positions, float(link), config)


def _groups(positions: np.ndarray, link_mm: float, config: FaceClusterConfig) -> list[np.ndarray]:
    """Groups of linked markers, largest first."""
    frames = np.unique(np.linspace(0, len(positions) - 1, min(len(positions), config.most_frames)).astype(int))
    X = positions[frames]
    count = X.shape[1]
    linked = np.zeros((count, count), dtype=bool)
    for i in range(count):
        distance = np.linalg.norm(X - X[:, i : i + 1], axis=2)
        linked[i] = _stays_near(distance, link_mm, config)
    group = connected_components(coo_array(linked | linked.T), directed=False)[1]
    order = np.argsort(-np.bincount(group), kind="stable")
    return [np.flatnonzero(group == g) for g in order]


def _stays_near(distance: np.ndarray, link_mm: float, config: FaceClusterConfig) -> Bool[np.ndarray, " markers"]:
    known = np.isfinite(distance).any(axis=0)
    low, middle, high = np.nanpercentile(np.where(known, distance, 1e9), [5, 50, 95], axis=0)
    return known & (middle < link_mm) & ((high - low) / 2 < config.bend_mm)


def _span(positions: np.ndarray) -> float:
    """Box diagonal of the markers in the frame that shows most, mm."""
    frame = positions[int(np.argmax(np.isfinite(positions).all(axis=2).sum(axis=1)))]
    there = frame[np.isfinite(frame).all(axis=1)]
    return float(np.linalg.norm(np.ptp(there, axis=0)))


def _no_face(markers: Markers, seen: np.ndarray, sizes: list[int], config: FaceClusterConfig) -> str:
    low, high = config.span_mm
    return (
        f"this is no face: of {len(seen)} markers no {config.fewest} stay together within {low:.0f}-{high:.0f} mm (the "
        f"largest group has {sizes[0]}); choose the face's with --markers PATTERN, or name the unit with --units"
    )


def _lines(markers: Markers, share: np.ndarray, kept: np.ndarray, faces: list, config) -> tuple[str, ...]:
    """What was left out, by reason."""
    out = np.setdiff1d(np.arange(len(markers.labels)), kept)
    seldom = out[share[out] < config.least_seen]
    others = faces[1:]
    second = np.concatenate(others) if others else np.zeros(0, dtype=int)
    stray = np.setdiff1d(out, np.concatenate([seldom, second]))
    said = (
        ("seen too seldom and left out", seldom[share[seldom] > 0]),
        ("another group as large as a face was left out (--markers chooses it)", second),
        ("not part of the face and left out (--markers chooses otherwise)", stray),
    )
    return tuple(f"{why}: {named_markers(markers.labels, which)}" for why, which in said if len(which))


_NAMED = 6
"""Labels named in one line."""


def named_markers(labels: tuple[str, ...], which: np.ndarray) -> str:
    """A few labels, for a line."""
    more = f" and {len(which) - _NAMED} more" if len(which) > _NAMED else ""
    return ", ".join(labels[i] for i in which[:_NAMED].tolist()) + more
