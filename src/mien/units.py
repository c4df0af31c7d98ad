"""Which unit a file of positions is in: as told, as written in the file, or as the size of a face gives away."""

from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from .clip import visible
from .errors import BadInput

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in one unit, in the order in which they are tried on a file that does not say."""

_NAMES = {
    "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    "cm": ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
    "m": ("m", "meter", "meters", "metre", "metres"),
    "in": ("in", "inch", "inches", '"'),
}
_BY_NAME = {alias: UNITS[unit] for unit, aliases in _NAMES.items() for alias in aliases}

FACE_SPAN_MM = (45.0, 400.0)
"""Box diagonals that are taken for the markers of one face. Layouts from mouth-only to brow, ears and chin measure
60 to 260; the rest is for a tilted head and a head band. The ratio is under ten: of mm, cm and m only one can fit."""

TYPICAL_SPAN_MM = 140.0
"""Box diagonal of the markers on an adult's brows, nose, cheeks and mouth: what `guess_unit` scales to."""

NEIGHBOUR_MM = (80.0, 60.0, 45.0, 30.0)
"""Longest links that are tried between neighbouring markers of one face: seven on a face stand about 60 mm apart, a
hundred 12; the shorter ones part a face from a dense body."""

CLUSTER_FRAMES = 40
"""Frames in which clusters are looked for: one frame may hold a ghost."""

FEWEST_TOGETHER = 6
"""Markers in a cluster that may be a face."""

FAR_SMALLER = 4.0
"""A cluster so many times smaller than the whole cloud is a part of its own: a body is eight faces high."""

LINK = 3.0
"""Longest link of a cluster, in distances of nearest neighbours (those of the nearer quarter)."""

LARGE_PART = 0.25
"""A cluster of fewer of the markers is no face beside a body, but a dense corner of something else."""

MOSTLY = 0.6
"""A cluster of so many of the markers says in which unit it is a face: the others are a helmet's, or props."""

MOST_CLUSTERED = 2000
"""Points beyond which no clusters are looked for: no capture has as many, and pairs grow with the square."""


def parse_unit(unit: str) -> float:
    """Millimetres in one `unit`: a name such as "mm", "cm", "m", "in", "metres", or a number such as "184.84".

    Raises:
        BadInput: neither.
    """
    found = known_unit(unit)
    if found is None:
        raise BadInput(f"unit {unit!r}: expected mm, cm, m, in, or the number of millimetres in one unit")
    return found


def known_unit(unit: str) -> float | None:
    """As `parse_unit`, but None for what is neither a unit's name nor a positive number."""
    name = unit.strip().lower()
    if name in _BY_NAME:
        return _BY_NAME[name]
    try:
        value = float(name)
    except ValueError:
        return None
    return value if 0 < value < np.inf else None


def cloud_span(positions: Float[np.ndarray, "frames markers 3"]) -> float:
    """Size of a marker cloud, in its own unit: the median over frames of the diagonal of the box around the markers.

    Only frames count that see at least as many markers as the middle one of the non-empty frames; NaN if none sees two.
    """
    seen = visible(positions)
    count = seen.sum(axis=1)
    if (count >= 2).sum() == 0:
        return float("nan")
    full = count >= max(2, np.median(count[count > 0]))
    inside = seen[full][:, :, None]
    points = positions[full]
    high = np.where(inside, points, -np.inf).max(axis=1)
    low = np.where(inside, points, np.inf).min(axis=1)
    return float(np.median(np.linalg.norm(high - low, axis=1)))


def fitting_units(span: float) -> list[str]:
    """The names in `UNITS` under which a cloud of size `span` (in its own unit) is as large as a face."""
    low, high = FACE_SPAN_MM
    return [name for name, mm in UNITS.items() if low <= span * mm <= high]


def guess_unit(positions: Float[np.ndarray, "frames markers 3"]) -> float:
    """Millimetres per unit that make the marker cloud as large as a typical face. A guess: absolute scale is not known.

    Adults' faces differ by about a tenth, layouts by more: where millimetres matter, measure a distance, name the unit.
    """
    return TYPICAL_SPAN_MM / cloud_span(positions)


def check_span(path: Path, positions: Float[np.ndarray, "frames markers 3"], mm: float, source: str) -> None:
    """Refuse a unit, told or written in the file, that makes no face of a cloud (in file units).

    A body, a prop or a second actor may stand beside the face: a cloud that is too large passes where some six markers
    lie together as a face's do. `source` says who named the unit.

    Raises:
        BadInput: with the unit that would make it a face.
    """
    span = cloud_span(positions)
    low, high = FACE_SPAN_MM
    if low <= span * mm <= high:
        return
    if span * mm > high and len(face_cluster(positions, mm)):
        return
    size = f"{path}: the markers span {_length(span * mm)} with {mm:g} mm a unit ({source}), but a face spans 60-260 mm"
    fits = fitting_units(span)
    if not fits and span * mm > high:
        raise BadInput(
            f"{size}, and no {FEWEST_TOGETHER} of them stand together as a face's do; is it a body? name the face's "
            "markers by a pattern (--markers 'FACE*'), or the unit where that is wrong (--units)"
        )
    better = fits[0] if fits else f"{TYPICAL_SPAN_MM / span:.4g}"
    why = "would make it a face" if fits else "(mm per unit, a guess from its size) would make it a face"
    raise BadInput(f"{size}; --units {better} {why}")


def settle_unit(path: Path, positions: Float[np.ndarray, "frames markers 3"]) -> tuple[float, str, str]:
    """The unit of a file that names none: (mm per unit, "assumed" or "guessed", a line that says so).

    The first of mm, cm, m, in that makes the cloud a face, or else its largest cluster where that is far smaller (a
    body, a prop beside the face), or else most of the markers (a helmet above it); where none does (a 3D program's own
    units), `guess_unit`.
    """
    span = cloud_span(positions)
    spans = [span]
    core = largest_cluster(positions)
    if len(core) >= max(FEWEST_TOGETHER, LARGE_PART * positions.shape[1]):
        core_span = cloud_span(positions[:, core])
        spans += [core_span] if core_span * FAR_SMALLER < span else []
    for metric in (True, False):
        found = next(((size, name) for size in spans for name in fitting_units(size) if (name != "in") == metric), None)
        if found is not None:
            size, name = found
            part = "the markers span" if size == span else f"a cluster of {len(core)} markers spans"
            note = f"{path}: no unit named; read as {name}, in which {part} {size * UNITS[name]:.0f} mm"
            return UNITS[name], "assumed", note
    for name, mm in UNITS.items():
        together = face_cluster(positions, mm) if span * mm > FACE_SPAN_MM[1] else []
        if len(together) >= MOSTLY * positions.shape[1]:
            part = f"{len(together)} markers stand together as a face's do"
            return mm, "assumed", f"{path}: no unit named; read as {name}, in which {part}"
    mm = guess_unit(positions)
    note = (
        f"{path}: no unit named and none makes a face of a span of {span:.4g}; scaled by {mm:.4g} to a typical "
        f"{TYPICAL_SPAN_MM:.0f} mm, so absolute size is a guess (--units NUMBER gives the millimetres in one unit)"
    )
    return mm, "guessed", note


def face_cluster(positions: Float[np.ndarray, "frames markers 3"], mm: float) -> Int[np.ndarray, " members"]:
    """The markers that stand together and span a face (positions times `mm` are millimetres); empty where none do.

    Of frames spread over the take, those count in which a marker is seen; it belongs where it does in most of them.
    """
    seen = visible(positions)
    count = seen.sum(axis=1)
    full = np.flatnonzero(count >= max(FEWEST_TOGETHER, np.median(count[count > 0]) if count.any() else 0))
    frames = full[np.linspace(0, len(full) - 1, min(len(full), CLUSTER_FRAMES)).astype(np.int64)]
    low, high = FACE_SPAN_MM
    for radius in NEIGHBOUR_MM:
        votes = np.zeros(positions.shape[1])
        for frame in frames:
            votes[largest_cluster(positions[frame : frame + 1], radius / mm)] += 1
        members = np.flatnonzero(2 * votes > seen[frames].sum(axis=0))
        if len(members) >= FEWEST_TOGETHER and low <= cloud_span(positions[:, members]) * mm <= high:
            return members
    return np.zeros(0, np.int64)


def largest_cluster(
    positions: Float[np.ndarray, "frames markers 3"], radius: float | None = None
) -> Int[np.ndarray, " members"]:
    """The markers of the largest group that neighbours chain together, in the frame that sees the most markers.

    `radius` is the longest link, in the positions' unit; by default `LINK` times the distance of nearest
    neighbours in the nearer quarter.
    """
    seen = visible(positions)
    count = seen.sum(axis=1)
    if len(count) == 0 or not 2 <= count.max() <= MOST_CLUSTERED:
        return np.zeros(0, np.int64)
    frame = int(np.argmax(count))
    there = np.flatnonzero(seen[frame])
    tree = cKDTree(positions[frame, there])
    if radius is None:
        radius = LINK * float(np.quantile(tree.query(tree.data, k=2)[0][:, 1], 0.25))
    links = tree.query_pairs(radius, output_type="ndarray")
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(there), len(there)))
    _, group = connected_components(graph, directed=False)
    return there[group == np.argmax(np.bincount(group))]


def _length(mm: float) -> str:
    for size, name in ((1e6, "km"), (1e3, "m"), (1.0, "mm")):
        if mm >= size:
            return f"{mm / size:.3g} {name}"
    return f"{mm:.2g} mm"
