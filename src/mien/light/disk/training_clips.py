"""Takes of clips in, training clips out: `CLIP/markers.c3d` and `CLIP/frame_000000.ply`, ..., in one topology."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...clip import Markers
from ...errors import BadInput
from ...files import existing
from ...io.markers import write_c3d
from ...io.meshes import write_ply
from ...mesh import Mesh
from ...pictures.color import to_srgb
from ...progress import SILENT, Progress
from ...transforms import Transform
from ..light_rig import LightRig
from ..patterns import PatternSet
from ..pipeline import LightConfig, decode_capture
from ..training.clips import LostFrame, TrainingConfig, common_neutral, registered_clip, shown_positions
from ..training.common_surface import CommonSurface, RegisteredSkin
from .light_scan import LightScan
from .light_take import LightTake, read_light_take

NEUTRAL = "neutral"
"""The clip of this name holds the neutral; without it the first clip's first capture is the neutral."""
WHITE = 0.98
"""Quantile of the neutral's albedo that is written as white."""


@dataclass(frozen=True)
class WrittenClips:
    """What was written."""

    frames: int
    dots: int
    vertices: int
    T_face_rig: Transform
    """Of everything that was written."""
    notes: tuple[str, ...]
    """A line for each capture or clip that was left out."""


def read_clip_takes(
    folder: str | Path, calibration: str | Path | None = None
) -> tuple[dict[str, LightTake], list[str]]:
    """Takes by the name of their folder, and lines on those that cannot be read.

    Raises:
        BadInput: no such folder, or no take in it.
    """
    folder, takes, notes = existing(folder), {}, []
    if not folder.is_dir():
        raise BadInput(f"{folder}: expected a folder with a folder of pictures for each clip")
    for place in sorted(p for p in folder.iterdir() if p.is_dir() and not p.name.startswith(".")):
        try:
            takes[place.name] = read_light_take(place, calibration)
        except BadInput as error:
            notes.append(f"left out: {error}")
    if not takes:
        raise BadInput(f"{folder}: no clips in it; give each a folder of its own{f' ({notes[0]})' if notes else ''}")
    return takes, notes


def write_training_clips(
    folder: Path,
    takes: dict[str, LightTake],
    light: LightConfig = LightConfig(),
    config: TrainingConfig = TrainingConfig(),
    progress: Progress = SILENT,
) -> WrittenClips:
    """Decode every capture, bring it into the neutral's texture space, write it.

    A vertex that a frame does not show has no triangle in that frame's file. Face space: the lamps' axes, the neutral's
    middle at the origin. Dots are called D000 and so on, from above down; a lost one is a gap.

    Raises:
        BadInput: a neutral that cannot be decoded, or has no dots.
    """
    first = NEUTRAL if NEUTRAL in takes else next(iter(takes))
    neutral = decode_capture(takes[first].capture(0), takes[first].patterns, takes[first].rig, light)
    surface = common_neutral(neutral, config)
    placed = T_face_rig(surface, takes[first].rig)
    writer = ClipWriter(folder, surface, placed)
    still = RegisteredSkin(surface.mesh.vertices, np.ones(len(surface.albedo), bool), surface.albedo)
    writer.frame(NEUTRAL, 0, still)
    writer.markers(NEUTRAL, surface.dots[None], takes[first].patterns)
    notes, count, done, total = [], 0, 0, sum(map(len, takes.values()))
    for name, take in takes.items():
        if name == NEUTRAL:
            continue
        view = next(view for view in take.rig.cameras if view.name in take.pictures)
        positions = np.full((len(take), *surface.dots.shape), np.nan)
        for frame in registered_clip(surface, _scans(take, light), view, config):
            done += 1
            progress.update("captures", done, total)
            if isinstance(frame, LostFrame):
                notes.append(f"{name}, capture {frame.number} left out: {frame.why}")
                continue
            positions[frame.number] = shown_positions(frame.dots)
            writer.frame(name, frame.number, frame.skin)
            count += 1
        if np.isfinite(positions).any():
            writer.markers(name, positions, take.patterns)
    return WrittenClips(count, len(surface.dots), len(surface.albedo), placed, tuple(notes))


def _scans(take: LightTake, config: LightConfig) -> Iterator[LightScan | BadInput]:
    for number in range(len(take)):
        try:
            yield decode_capture(take.capture(number), take.patterns, take.rig, config)
        except BadInput as error:
            yield error


def T_face_rig(surface: CommonSurface, rig: LightRig) -> Transform:
    """Lamps stand round the face as its own axes: y up, z out of it."""
    rotation = np.array(rig.R_rig_lamps).T
    return Transform(rotation, -rotation @ surface.mesh.vertices.mean(axis=0))


class ClipWriter:
    """Frames and dots of clips in face space, under the names that `mien detail fit` looks for."""

    def __init__(self, folder: Path, surface: CommonSurface, T_face_rig: Transform):
        self.folder, self.surface, self.T_face_rig = folder, surface, T_face_rig
        self.order = np.argsort(surface.dots @ T_face_rig.rotation[1])[::-1]
        self.white = max(float(np.nanquantile(surface.albedo, WHITE)), 1e-9)

    def frame(self, clip: str, number: int, skin: RegisteredSkin) -> None:
        """One frame's mesh, grey by its albedo."""
        (self.folder / clip).mkdir(parents=True, exist_ok=True)
        grey = to_srgb(np.clip(np.nan_to_num(skin.albedo) / self.white, 0, 1))
        mesh = self.surface.mesh
        seen = skin.seen[mesh.faces].all(axis=1)
        made = Mesh(self.T_face_rig.apply(skin.vertices), mesh.faces[seen], mesh.uv)
        colors = np.repeat(grey[:, None], 3, axis=1)
        write_ply(self.folder / clip / f"frame_{number:06d}.ply", replace(made, colors=colors))

    def markers(self, clip: str, positions: np.ndarray, patterns: PatternSet) -> None:
        """The clip's dots, (frames, k, 3), as C3D."""
        labels = tuple(f"D{i:03d}" for i in range(len(self.order)))
        rate = patterns.rate / len(patterns)
        take = Markers(self.T_face_rig.apply(positions[:, self.order]), labels, rate)
        write_c3d(self.folder / clip / "markers.c3d", take)
