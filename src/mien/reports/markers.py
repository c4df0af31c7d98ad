"""What a marker solve found, in pictures and figures."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, UInt8
from PIL import Image, ImageDraw

from ..clip import Markers
from ..markers.pipeline import TakeSolve
from ..pictures import Renderer, bar_chart, contact_sheet, frontal_camera, label, line_chart
from ..pictures.show import rig_look
from ..pictures.view import View
from ..progress import SILENT, Progress
from ..rig import Performance
from .page import Report
from .verdict import solve_verdict

PREVIEW_FRAMES = 8


def telling_frames(performance: Performance, count: int = PREVIEW_FRAMES) -> list[int]:
    """Frames that show the take, in order: the weakest expression, then ever the one most unlike those taken."""
    usable = np.flatnonzero(performance.tracked)
    if len(usable) == 0:
        usable = np.arange(len(performance))
    usable = usable[np.linspace(0, len(usable) - 1, min(len(usable), 2000)).astype(int)]
    moved = np.linalg.norm(performance.rig.deltas, axis=2).mean(axis=1)
    W = performance.weights[usable] * moved
    chosen = [int(np.argmin(np.abs(W).sum(axis=1)))]
    distance = np.full(len(usable), np.inf)
    while len(chosen) < min(count, len(usable)):
        distance = np.minimum(distance, np.linalg.norm(W - W[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(distance)))
    return sorted(int(usable[i]) for i in chosen)


def preview(solved: TakeSolve, size: int = 420, progress: Progress = SILENT) -> UInt8[np.ndarray, "h w 3"]:
    """A contact sheet of telling frames, the recorded markers drawn on the face."""
    performance, markers = solved.performance, solved.markers
    frames = telling_frames(performance)
    view = frontal_camera(performance.rig.neutral, (size, round(size * 1.25)), yaw=0.3)
    renderer = Renderer(performance.rig.neutral, rig_look(performance.rig.neutral), performance.rig.texture)
    images = []
    for number, frame in enumerate(frames):
        vertices = performance.rig.vertices(performance.weights[frame])
        image = renderer.draw(view.camera, view.T_camera_face, vertices=vertices)
        seen = solved.T_lab_face[frame].inverse().apply(markers.positions[frame])
        image = with_dots(image, view, seen[np.isfinite(seen).all(axis=1)])
        images.append(label(image, f"{frame / markers.rate:.2f} s"))
        progress.update("drawing", number + 1, len(frames))
    return contact_sheet(images, columns=4)


def with_dots(
    image: UInt8[np.ndarray, "h w 3"], view: View, points: Float[np.ndarray, "p 3"]
) -> UInt8[np.ndarray, "h w 3"]:
    """The picture with points (face space, mm) drawn over it as small bright dots."""
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    radius = max(1.5, image.shape[0] / 240)
    for u, v in view.camera.project(view.T_camera_face.apply(points)):
        draw.ellipse((u - radius, v - radius, u + radius, v + radius), fill=(250, 250, 245), outline=(40, 90, 150))
    return np.asarray(picture)


def take_report(
    name: str,
    solved: TakeSolve,
    picture: UInt8[np.ndarray, "h w 3"],
    notes: Sequence[str] = (),
    moving: str | None = None,
) -> Report:
    """The report of `mien solve`: verdict, the moving face (a page), worst markers, what to do; the rest is folded."""
    markers = solved.markers
    report = Report(f"{name}: markers to an animated face", _lead(solved, markers))
    report.verdict(solve_verdict(float(np.nanmean(solved.residuals)), solved.left_out.left_out_share))
    if moving is not None:
        report.page(moving, "Drag to turn, wheel to come nearer; space plays.")
    report.figure(picture, "Frames that differ most. Dots are the recorded markers, seen in the head's frame.")
    if solved.regions:
        rows = [(region.name, region.markers, region.told) for region in solved.regions]
        report.heading("How well each region is told").table(rows, ("region", "markers", "of a frozen face's error"))
        report.text(REGIONS_MEAN)
    worst = worst_markers(solved.residuals, markers)
    report.heading("The worst markers").table(worst, ("marker", "mean residual, mm", "seen"))
    report.text(
        "A marker that stands out was probably named wrongly, slid, or sits where skin slides over bone: look at it "
        "with `mien view`, and leave it out with --markers if it is not the face's."
    )
    for note in [*notes, *solved.lines, *_doubts(solved)]:
        report.text(note)
    report.folded("Figures", Report("").table(_figures(solved, markers), ("", "")))
    report.folded("Residual of every marker, and over time", _residual_charts(solved))
    return report.folded("Weights", _weight_charts(solved.performance))


REGIONS_MEAN = (
    "How far a region's markers are from where the others tell them when they are left out by turns, as a share of how "
    "far a frozen face would be. Where no marker sits the face moves as its shapes do, unseen; gaze and tongue always."
)
WORST = 5
"""Markers that a report names first."""


def worst_markers(
    residuals: Float[np.ndarray, "frames markers"], markers: Markers
) -> list[tuple[str, float, str]]:
    """Name, mean residual (mm) and share of frames seen of the markers that are met worst."""
    means = _nanmean(residuals, 0)
    known = np.flatnonzero(np.isfinite(means))
    worst = known[np.argsort(-means[known])][:WORST]
    seen = markers.seen.mean(axis=0)
    return [(markers.labels[i], float(means[i]), f"{seen[i]:.0%}") for i in worst]


def _residual_charts(solved: TakeSolve) -> Report:
    residuals, labels = solved.residuals, solved.markers.labels
    means = {n: float(m) for n, m in zip(labels, _nanmean(residuals, 0), strict=True) if np.isfinite(m)}
    part = Report("").chart(bar_chart(means, x_label="mean distance from marker to model, mm"))
    times, every = _times(solved.performance)
    series = {"mean over markers": (times, _nanmean(residuals, 1)[::every])}
    return part.chart(line_chart(series, "seconds", "mm"), "Residual over time.")


def _weight_charts(performance: Performance) -> Report:
    times, every = _times(performance)
    ranked = np.argsort(-performance.weights.std(axis=0))[:6]
    lines = {performance.rig.names[k]: (times, performance.weights[::every, k]) for k in ranked}
    part = Report("").chart(line_chart(lines, "seconds", "weight"), "The six shapes that move most.")
    columns = zip(performance.rig.names, performance.weights.T, strict=True)
    return part.table([(name, f"{w.mean():.3f}", f"{w.max():.2f}") for name, w in columns], ("shape", "mean", "most"))


def _times(performance: Performance) -> tuple[np.ndarray, int]:
    """Seconds of the frames that a chart shows, and every how many-th they are."""
    times = np.arange(len(performance)) / performance.rate
    every = max(1, len(times) // 1500)
    return times[::every], every


def _lead(solved: TakeSolve, markers: Markers) -> str:
    frames = len(markers.positions)
    known = str(solved.left_out) or f"mean residual {np.nanmean(solved.residuals):.2f} mm"
    return f"{frames} frames at {markers.rate:g} a second, {len(markers.labels)} markers; {known}."


def _figures(solved: TakeSolve, markers: Markers) -> list[tuple[str, str]]:
    calibration, residuals = solved.calibration, solved.residuals
    seen = markers.seen
    second_best = "none found" if np.isinf(calibration.second_best_mm) else f"{calibration.second_best_mm:.2f} mm"
    return [
        ("markers left out by turns", str(solved.left_out) or "not tried"),
        ("mean residual", f"{np.nanmean(residuals):.3f} mm"),
        ("95th percentile", f"{np.nanpercentile(residuals, 95):.3f} mm"),
        ("margin over the best other alignment (0 to 1)", f"{calibration.alignment_margin:.2f}"),
        ("residual of the best other alignment", second_best),
        ("neutral frame", f"{calibration.neutral.frame}"),
        ("motion that is added to it", f"{100 * calibration.neutral.added:.0f} %"),
        ("markers' distance from the skin", f"{calibration.standoff.mean():.1f} mm"),
        ("samples seen", f"{100 * seen.mean():.1f} %"),
        ("samples left out as outliers", f"{int((seen & ~solved.used & solved.performance.tracked[:, None]).sum())}"),
        ("frames tracked", f"{int(solved.performance.tracked.sum())} of {len(seen)}"),
    ]


def _doubts(solved: TakeSolve) -> list[str]:
    doubts = []
    if not solved.depth_known:
        doubts.append(
            "Depth is no measurement in this take: each marker's depth follows from its place in the image, as a "
            "single camera's does. It counted for a hundredth of the other directions; protrusion (pucker, jaw "
            "forward) and nods are therefore guesses."
        )
    return doubts


def _nanmean(values: np.ndarray, axis: int) -> np.ndarray:
    known = np.isfinite(values)
    return np.where(known.any(axis=axis), np.nansum(values, axis=axis) / np.maximum(known.sum(axis=axis), 1), np.nan)
