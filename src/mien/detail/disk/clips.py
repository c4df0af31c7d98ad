"""Training clips on disk: a folder a clip, with a marker take and one mesh a frame, all meshes in one topology."""

import re
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
from ...takes.gaps import fill_gaps
from ..training import Clip, Frame, TrainingSet

MARKER_SUFFIXES = (".c3d", ".trc", ".csv", ".tsv")
MESH_SUFFIXES = (".ply", ".obj", ".stl", ".glb")
NEUTRAL = "neutral"
"""A folder of this name holds the neutral; without it the first clip's first frame is the neutral."""


def read_training(folder: str | Path, unit: str | None = None) -> tuple[TrainingSet, list[str]]:
    """`folder/CLIP/markers.c3d` and `folder/CLIP/*_000000.ply`, ...: a training set, and lines on what was left out.

    A mesh belongs to the marker frame whose number ends its name, counted from 0; marker frames without a mesh are
    dropped. A vertex without a triangle is not seen in its frame. Markers are matched by label: those that every clip
    has are used.

    Args:
        unit: of the meshes: mm, cm, m, in; millimetres where None.

    Raises:
        BadInput: no such folder, or no clip in it that can be read.
    """
    folder, notes, takes = existing(folder), [], {}
    for place in sorted(p for p in folder.iterdir() if p.is_dir() and not p.name.startswith(".")):
        try:
            takes[place.name] = _take(place)
        except BadInput as error:
            notes.append(f"left out: {error}")
    if not takes:
        told = f" ({notes[0]})" if notes else ""
        raise BadInput(f"{folder}: no clips in it; give each a folder with its markers and a mesh a frame{told}")
    labels = _shared_labels(takes)
    first = NEUTRAL if NEUTRAL in takes else next(iter(takes))
    mesh = read_scan(takes[first][1][0], unit).mesh
    clips = {name: _clip(name, take, meshes, labels, unit) for name, (take, meshes) in takes.items()}
    used = tuple(clip for name, clip in clips.items() if name != NEUTRAL or len(takes) == 1)
    return TrainingSet(mesh, clips[first].markers[0], labels, used), notes


def _take(place: Path) -> tuple[Markers, list[Path]]:
    """A clip's markers at its meshes' frames, and those meshes."""
    files = sorted(place.iterdir())
    markers = [p for p in files if p.suffix.lower() in MARKER_SUFFIXES]
    meshes = {int(found[1]): p for p in files if p.suffix.lower() in MESH_SUFFIXES and (found := _number(p))}
    if len(markers) != 1:
        raise BadInput(f"{place}: {len(markers)} marker files; a clip has one")
    if not meshes:
        raise BadInput(f"{place}: no meshes whose names end in a frame number, such as frame_000012.ply")
    take = read_markers(markers[0])
    beyond = [number for number in meshes if number >= len(take.positions)]
    if beyond:
        raise BadInput(f"{meshes[beyond[0]]}: frame {beyond[0]}, and the take has {len(take.positions)}")
    order = sorted(meshes)
    filled = fill_gaps(take.positions, take.rate)
    return take.with_positions(filled[order]), [meshes[number] for number in order]


def _number(path: Path) -> re.Match[str] | None:
    return re.search(r"(\d+)$", path.stem)


def _shared_labels(takes: dict[str, tuple[Markers, list[Path]]]) -> tuple[str, ...]:
    """Labels that every clip shows in every frame that is used, in the first clip's order."""
    shown = []
    for take, _ in takes.values():
        whole = np.asarray(np.isfinite(take.positions).all(axis=(0, 2)))
        shown.append({label for label, here in zip(take.labels, whole, strict=True) if here})
    first, _ = next(iter(takes.values()))
    labels = tuple(label for label in first.labels if all(label in others for others in shown))
    if len(labels) < 3:
        raise BadInput(
            f"{len(labels)} markers are in every clip and frame; clips of one training set carry the same labels"
        )
    return labels


def _clip(name: str, take: Markers, meshes: list[Path], labels: tuple[str, ...], unit: str | None) -> Clip:
    place = {label: i for i, label in enumerate(take.labels)}

    def frames() -> Iterator[Frame]:
        for path in meshes:
            mesh = read_scan(path, unit).mesh
            yield Frame(shown_vertices(mesh), mesh.colors)

    return Clip(name, take.positions[:, [place[label] for label in labels]], frames)


def shown_vertices(mesh: Mesh) -> Float[np.ndarray, "n 3"]:
    """Vertices, NaN for those without a triangle: the frame does not show them."""
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    return np.where(used[:, None], mesh.vertices, np.nan)
