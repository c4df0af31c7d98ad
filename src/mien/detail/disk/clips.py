"""Training clips on disk: a folder a clip, with a marker take and one mesh a frame, all meshes in one topology."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ...clip import Markers
from ...errors import BadInput
from ...files import existing
from ...io.markers import read_markers
from ...io.meshes import read_scan
from ...mesh import Mesh
from ...mesh.scan_color import vertex_colours
from ...pictures.color import to_linear
from ...register import procrustes_frames
from ...takes.gaps import fill_gaps
from ..training import Clip, Frame, TrainingSet

MARKER_SUFFIXES = (".c3d", ".trc", ".csv", ".tsv")
MESH_SUFFIXES = (".ply", ".obj", ".stl", ".glb")
NEUTRAL = "neutral"
"""A folder of this name holds the neutral; without it the start that most clips agree on is the neutral."""
LEAST_FRAMES = 2
"""Of a clip, which goes from neutral to an expression."""
LEAST_SHARED = 0.5
"""Share of the usual markers that a clip must show: one with fewer would take the rest from all others."""
NEUTRAL_MM = 2.0
"""Rms of the markers within which a frame is neutral: a person comes back to rest within about 1 mm."""

_Take = tuple[Markers, list[Path]]
"""A clip's markers at its meshes' frames, and those meshes."""


def read_training(folder: str | Path, unit: str | None = None) -> tuple[TrainingSet, list[str]]:
    """`folder/CLIP/markers.c3d` and `folder/CLIP/*_000000.ply`, ...: a training set, and lines on what was left out.

    A mesh belongs to the marker frame whose number ends its name, counted from 0; marker frames without a mesh are
    dropped. A vertex without a triangle is not seen in its frame. Markers are matched by label: those that every clip
    has are used. A clip of one frame, of other markers or of another topology is left out, and so is a mesh within a
    clip that cannot be read or has another topology: the lines get one on it when the clip's frames are asked for.

    Args:
        unit: of the meshes: mm, cm, m, in; millimetres where None.

    Raises:
        BadInput: no such folder, or no clip in it that can be read.
    """
    folder = existing(folder)
    takes, notes = _takes(folder)
    _check_some(folder, takes, notes)
    takes = _without(takes, _of_other_markers(takes), notes)
    labels = _shared_labels(takes)
    first = NEUTRAL if NEUTRAL in takes else _commonest_start(takes, labels)
    mesh = read_scan(takes[first][1][0], unit).mesh
    takes = _without(takes, _of_other_topology(takes, mesh, unit), notes)
    _check_some(folder, takes, notes)
    neutral = _positions(takes[first][0], labels)[0]
    notes += _far_from_neutral(takes, labels, neutral)
    clips = {name: _clip(name, *take, labels, unit, len(mesh.vertices), notes) for name, take in takes.items()}
    used = tuple(clip for name, clip in clips.items() if name != NEUTRAL or len(takes) == 1)
    return TrainingSet(mesh, neutral, labels, used), notes


def _takes(folder: Path) -> tuple[dict[str, _Take], list[str]]:
    """Every clip that can be read, by name, and a line on each that cannot."""
    takes, notes = {}, []
    for place in sorted(p for p in folder.iterdir() if p.is_dir() and not p.name.startswith(".")):
        try:
            takes[place.name] = _take(place)
        except BadInput as error:
            notes.append(f"left out: {error}")
    return takes, notes


def _check_some(folder: Path, takes: dict[str, _Take], notes: list[str]) -> None:
    """Refuse a folder in which nothing goes from neutral to an expression."""
    if any(name != NEUTRAL or len(meshes) >= LEAST_FRAMES for name, (_, meshes) in takes.items()):
        return
    told = f" ({notes[0]})" if notes else ""
    raise BadInput(f"{folder}: no clips in it; give each a folder with its markers and a mesh a frame{told}")


def _without(takes: dict[str, _Take], wrong: dict[str, str], notes: list[str]) -> dict[str, _Take]:
    """The clips that nothing is wrong with; `notes` gets a line on each of the others."""
    notes += [f"left out: {why}" for why in wrong.values()]
    return {name: take for name, take in takes.items() if name not in wrong}


def _of_other_markers(takes: dict[str, _Take]) -> dict[str, str]:
    """Clips that show fewer than half of the labels that at least half of all clips show, and why."""
    shown = {name: _shown_labels(take) for name, (take, _) in takes.items()}
    times = Counter(label for labels in shown.values() for label in labels)
    usual = {label for label, count in times.items() if 2 * count >= len(takes)}
    wrong = {}
    for name, labels in shown.items():
        common = len(labels & usual)
        if common < LEAST_SHARED * len(usual):
            place = takes[name][1][0].parent
            wrong[name] = f"{place}: {common} of the {len(usual)} markers of the other clips; give it the same labels"
    return wrong


def _of_other_topology(takes: dict[str, _Take], neutral: Mesh, unit: str | None) -> dict[str, str]:
    """Clips whose first mesh has another number of vertices than the neutral, or cannot be read, and why."""
    wrong = {}
    for name, (_, meshes) in takes.items():
        try:
            count = len(read_scan(meshes[0], unit).mesh.vertices)
        except BadInput as error:
            wrong[name] = str(error)
            continue
        if count != len(neutral.vertices):
            wrong[name] = (
                f"{meshes[0]}: {count:,} vertices where the neutral has {len(neutral.vertices):,}; "
                "all meshes of a training set share one topology"
            )
    return wrong


def _commonest_start(takes: dict[str, _Take], labels: tuple[str, ...]) -> str:
    """The clip whose first frame is nearest to most others' first frames."""
    starts = np.stack([_positions(take, labels)[0] for take, _ in takes.values()])
    away = [np.median(_distances_mm(start, starts)) for start in starts]
    return list(takes)[int(np.argmin(away))]


def _far_from_neutral(takes: dict[str, _Take], labels: tuple[str, ...], neutral: np.ndarray) -> list[str]:
    """A line on each clip that never comes near the neutral: it is used, and what it starts from may be wrong."""
    notes = []
    for take, meshes in takes.values():
        nearest = float(_distances_mm(neutral, _positions(take, labels)).min())
        if nearest > NEUTRAL_MM:
            notes.append(
                f"{meshes[0].parent}: no neutral frame (the nearest is {nearest:.1f} mm off); used all the same: "
                f"start clips at rest, or add a folder `{NEUTRAL}`"
            )
    return notes


def _distances_mm(
    reference: Float[np.ndarray, "k 3"], positions: Float[np.ndarray, "frames k 3"]
) -> Float[np.ndarray, " frames"]:
    """Rms distance of the markers from the reference, the head's motion taken out, frame by frame."""
    return np.asarray(procrustes_frames(reference, positions).rms)


def _take(place: Path) -> _Take:
    """A clip's markers at its meshes' frames, and those meshes."""
    files = sorted(place.iterdir())
    markers = [p for p in files if p.suffix.lower() in MARKER_SUFFIXES]
    meshes = {int(found[1]): p for p in files if p.suffix.lower() in MESH_SUFFIXES and (found := _number(p))}
    if len(markers) != 1:
        raise BadInput(f"{place}: {len(markers)} marker files; a clip has one")
    if not meshes:
        raise BadInput(f"{place}: no meshes whose names end in a frame number, such as frame_000012.ply")
    if len(meshes) < LEAST_FRAMES and place.name != NEUTRAL:
        raise BadInput(f"{place}: a clip of one frame; give meshes from neutral to the expression")
    take = read_markers(markers[0])
    beyond = [number for number in meshes if number >= len(take.positions)]
    if beyond:
        raise BadInput(f"{meshes[beyond[0]]}: frame {beyond[0]}, and the take has {len(take.positions)}")
    order = sorted(meshes)
    filled = fill_gaps(take.positions, take.rate)
    return take.with_positions(filled[order]), [meshes[number] for number in order]


def _number(path: Path) -> re.Match[str] | None:
    return re.search(r"(\d+)$", path.stem)


def _shown_labels(take: Markers) -> set[str]:
    """Labels shown in every frame that is used."""
    whole = np.asarray(np.isfinite(take.positions).all(axis=(0, 2)))
    return {label for label, here in zip(take.labels, whole, strict=True) if here}


def _shared_labels(takes: dict[str, _Take]) -> tuple[str, ...]:
    """Labels that every clip shows in every frame that is used, in the first clip's order."""
    shown = [_shown_labels(take) for take, _ in takes.values()]
    first, _ = next(iter(takes.values()))
    labels = tuple(label for label in first.labels if all(label in others for others in shown))
    if len(labels) < 3:
        raise BadInput(
            f"{len(labels)} markers are in every clip and frame; clips of one training set carry the same labels"
        )
    return labels


def _positions(take: Markers, labels: tuple[str, ...]) -> Float[np.ndarray, "frames k 3"]:
    place = {label: i for i, label in enumerate(take.labels)}
    return take.positions[:, [place[label] for label in labels]]


def _clip(
    name: str, take: Markers, meshes: list[Path], labels: tuple[str, ...], unit: str | None, count: int,
    notes: list[str],
) -> Clip:  # fmt: skip
    """A clip whose meshes are read when asked for; one that cannot be used shows nothing, and `notes` says so."""

    def frames() -> Iterator[Frame]:
        for path in meshes:
            try:
                yield _frame(path, unit, count)
            except BadInput as error:
                note = f"left out: {error}"
                if note not in notes:
                    notes.append(note)
                yield Frame(np.full((count, 3), np.nan))

    return Clip(name, _positions(take, labels), frames)


def _frame(path: Path, unit: str | None, count: int) -> Frame:
    """One mesh of a clip, in the neutral's topology."""
    scan = read_scan(path, unit)
    if len(scan.mesh.vertices) != count:
        raise BadInput(f"{path}: {len(scan.mesh.vertices):,} vertices where the neutral has {count:,}")
    colors = vertex_colours(scan)
    return Frame(shown_vertices(scan.mesh), None if colors is None else to_linear(colors))


def shown_vertices(mesh: Mesh) -> Float[np.ndarray, "n 3"]:
    """Vertices, NaN for those without a triangle: the frame does not show them."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    return np.where(used[:, None], mesh.vertices, np.nan)
