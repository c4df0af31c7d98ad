"""What tracking found, in pictures and figures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Float32, UInt8
from PIL import Image

from ..camera import Camera
from ..pictures import Renderer, colors_of, contact_sheet, frontal_camera, hstack, label, line_chart, scale_bar
from ..pictures.scale import PAPER
from ..pictures.show import rig_look, side_by_side
from ..progress import SILENT, Progress
from ..rgbd import RgbdTake
from ..rig import Performance, Rig
from ..rig.retarget import CORRECTIVE
from ..tracking.pipeline import T_WORLD_CAMERA, Tracked
from ..transforms import Transform
from .page import Report

NO_DEPTH = (0.11, 0.115, 0.12)
"""Colour of pixels without depth, sRGB."""


@dataclass(frozen=True)
class Crop:
    """A square of a take's picture round the head, and the camera that sees just that."""

    left: int
    top: int
    side: int
    """Pixels of the take."""
    size: int
    """Pixels of the cut-out."""

    def camera(self, camera: Camera) -> Camera:
        """The cut-out's camera."""
        k = self.size / self.side
        cx, cy = (camera.cx - self.left + 0.5) * k - 0.5, (camera.cy - self.top + 0.5) * k - 0.5
        return Camera(camera.fx * k, camera.fy * k, cx, cy, self.size, self.size)

    def cut(self, image: UInt8[np.ndarray, "h w 3"], smooth: bool = True) -> UInt8[np.ndarray, "s s 3"]:
        """The cut-out of an image; black beyond its border."""
        box = (self.left, self.top, self.left + self.side, self.top + self.side)
        how = Image.Resampling.BICUBIC if smooth else Image.Resampling.NEAREST
        return np.asarray(Image.fromarray(image).crop(box).resize((self.size, self.size), how))


def preview(
    take: RgbdTake, tracked: Tracked, frames: Sequence[int], size: int = 240, progress: Progress = SILENT
) -> UInt8[np.ndarray, "h w 3"]:
    """Colour, depth and tracked face side by side, two frames a row; `size` pixels a picture."""
    performance = tracked.performance
    T_camera_face = T_WORLD_CAMERA.inverse() @ performance.T_world_face
    crops = _crops(performance, T_camera_face, take.camera, frames, size)
    look = replace(rig_look(performance.rig.neutral), occlusion=0)
    renderer, rows, wanted = Renderer(performance.rig.neutral, look, performance.rig.texture), [], set(frames)
    for t, frame in enumerate(take):
        if t in wanted:
            crop, vertices = crops[t], performance.rig.vertices(performance.weights[t])
            parts = [] if frame.color is None else [crop.cut(frame.color)]
            if frame.depth is not None:
                distance = float(T_camera_face[t].translation[2])
                parts.append(crop.cut(depth_colors(frame.depth, distance), smooth=False))
            parts.append(renderer.draw(crop.camera(take.camera), T_camera_face[t], vertices=vertices))
            held = "" if performance.tracked[t] else "  head not in rays, held"
            rows.append(label(hstack(parts, gap=2), f"{t / performance.rate:.2f} s{held}", 22))
            progress.update("drawing", len(rows), len(wanted))
        if t >= max(wanted):
            break
    return contact_sheet(rows, columns=2 if len(rows) > 1 else 1, gap=8)


def depth_colors(
    depth: Float32[np.ndarray, "h w"], distance: float, reach: tuple[float, float] = (140.0, 40.0)
) -> UInt8[np.ndarray, "h w 3"]:
    """Depth in colours, near is yellow: from `reach` mm before `distance` (mm) to behind it. Dark: none."""
    near, behind = reach
    nearness = np.where(depth > 0, distance + behind - depth.astype(float), np.nan)
    colors = colors_of(np.clip(nearness, 0.0, None), (0.0, near + behind))
    colors[~(depth > 0)] = NO_DEPTH
    return (colors * 255 + 0.5).astype(np.uint8)


def _crops(performance: Performance, T_camera_face: Transform, camera: Camera, frames, size: int) -> dict[int, Crop]:
    """A square round the head in every frame, of one side, so that pictures can be compared."""
    some = performance.rig.neutral.vertices[::7]
    boxes = {}
    for t in frames:
        pixels = camera.project(T_camera_face[t].apply(some))
        boxes[t] = (pixels.min(0), pixels.max(0))
    side = round(1.08 * float(np.median([(high - low).max() for low, high in boxes.values()])))
    corners = {t: (low + high) / 2 - side / 2 for t, (low, high) in boxes.items()}
    return {t: Crop(round(x), round(y), side, size) for t, (x, y) in corners.items()}


Cell = tuple[str, Float[np.ndarray, "n 3"], Float[np.ndarray, " n"] | None]
"""A caption, a rig's vertices (mm), and one value a vertex (mm) where they are to be shown as colours."""


def faces_sheet(rig: Rig, cells: Sequence[Cell], limit: float, columns: int = 4) -> UInt8[np.ndarray, "h w 3"]:
    """Shapes of a rig, shaded or as heat maps from 0 to `limit` mm, with captions above and one scale."""
    neutral, look = rig.neutral, rig_look(rig.neutral)
    forward = neutral.vertices[neutral.vertices[:, 2] > np.median(neutral.vertices[:, 2])]
    view = frontal_camera(neutral, (260, 300), frame=forward, margin=0.03)
    plain, heat = Renderer(neutral, look), Renderer(neutral, replace(look, limits=(0.0, limit), value_shading=0.35))

    def draw(cell: Cell) -> np.ndarray:
        name, vertices, values = cell
        face = (plain if values is None else heat).draw(*view, vertices=vertices, values=values)
        caption = label(np.full((30, face.shape[1], 3), PAPER, dtype=np.uint8), name, 16)
        return np.concatenate([caption, face])

    sheet = contact_sheet(list(side_by_side(draw, cells)), columns=columns, gap=3)
    return hstack([sheet, scale_bar(84, sheet.shape[0], (0.0, limit), upright=True)], gap=0)


def learning_chart(
    rate: float,
    to_anchors: Float[np.ndarray, " t"],
    to_adaptive: Float[np.ndarray, " t"],
    spans: Sequence[tuple[float, float, str]] = (),
) -> str:
    """The paper's fig. 11: distance of the final mesh from the two spaces over time."""
    times = np.arange(len(to_anchors)) / rate
    series = {"to the anchor space": (times, to_anchors), "to the adaptive space": (times, to_adaptive)}
    return line_chart(series, "seconds", "mm, root mean square", spans=spans)


def take_report(
    take: RgbdTake,
    tracked: Tracked,
    picture: UInt8[np.ndarray, "h w 3"],
    notes: Sequence[str] = (),
    spans: Sequence[tuple[float, float, str]] = (),
) -> Report:
    """The report of `mien track`: picture, figures, what was learnt. `weights_section` ends it.

    Args:
        spans: stretches of time to name in the chart of what was learnt: (from, to, name), seconds.
    """
    performance = tracked.performance
    kind = "an RGB-D take" if take.has_depth else "colour video alone"
    seen = int(performance.tracked.sum())
    lead = f"{len(performance)} frames at {performance.rate:g} a second from {kind}; {seen} tracked."
    report = Report(f"{take.name}: tracked face", lead)
    parts = "Colour, depth (near is yellow, dark is none) and" if take.has_depth else "Colour and"
    report.figure(picture, f"{parts} the tracked face, in frames that differ most.")
    for note in [*notes, *doubts(take, tracked)]:
        report.text(note)
    report.heading("How it went").table(figures(take, tracked), ("", ""))
    if tracked.learnt:
        report.heading("What was learnt").chart(
            learning_chart(performance.rate, tracked.to_anchors, tracked.to_adaptive, spans),
            "Distance of the final mesh from what the blendshapes span (anchors) and from what they span together with "
            "the correctives learnt up to that frame. The closer, the better the expression was known.",
        )
    return report


def figures(take: RgbdTake, tracked: Tracked) -> list[tuple[str, str]]:
    """(what, how much) of a tracked take."""
    performance = tracked.performance
    rows = [
        ("frames tracked", f"{int(performance.tracked.sum())} of {len(performance)}"),
        ("spans without a face", ", ".join(_spans(performance)) or "none"),
    ]
    if take.has_depth:
        rows += [
            ("distance from the depth after the rigid step, mean", f"{np.nanmean(tracked.errors):.2f} mm"),
            ("frames that taught the correctives", f"{tracked.learnt}"),
        ]
    correctives = sum(name.startswith(CORRECTIVE) for name in performance.rig.names)
    return [*rows, ("corrective shapes in the result", f"{correctives}")]


def doubts(take: RgbdTake, tracked: Tracked) -> list[str]:
    """What a reader should know before trusting the result."""
    notes = []
    if tracked.stopped:
        notes.append(f"The take ended early: {tracked.stopped}. What was tracked until then is kept.")
    if tracked.missed:
        notes.append(f"{tracked.missed} frames came while the tracker was busy; they hold the last value.")
    if not take.has_depth:
        notes.append(
            "There was no depth: the head's distance, and everything that moves towards the camera (jaw forward, "
            "pucker, nods), are guesses from the landmarks."
        )
    if take.guessed_camera:
        notes.append(f"The lens was taken to be {take.camera.fx:.0f} pixels long; --focal sets it.")
    share = float(tracked.performance.tracked.mean())
    if share < 0.8:
        notes.append(f"Only {100 * share:.0f} % of the frames were tracked; the others hold the last value.")
    return notes


def _spans(performance: Performance) -> list[str]:
    """"1.20 to 1.53 s" for each run of frames that were not tracked."""
    lost = np.concatenate([[False], ~performance.tracked, [False]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(lost) == 1), np.flatnonzero(np.diff(lost) == -1)
    return [f"{a / performance.rate:.2f} to {b / performance.rate:.2f} s" for a, b in zip(starts, ends, strict=True)]


def weights_section(report: Report, performance: Performance) -> Report:
    """Add the shapes that moved most, over time, and a table of all."""
    own = [i for i, name in enumerate(performance.rig.names) if not name.startswith(CORRECTIVE)]
    times = np.arange(len(performance)) / performance.rate
    ranked = sorted(own, key=lambda k: -float(performance.weights[:, k].std()))[:6]
    lines = {performance.rig.names[k]: (times, performance.weights[:, k]) for k in ranked}
    report.heading("Weights").chart(line_chart(lines, "seconds", "weight"), "The six shapes that move most.")
    rows = [(performance.rig.names[k], performance.weights[:, k]) for k in own]
    return report.table([(name, f"{w.mean():.3f}", f"{w.max():.2f}") for name, w in rows], ("shape", "mean", "most"))
