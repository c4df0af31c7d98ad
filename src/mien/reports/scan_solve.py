"""What `mien solve` shows of a take that was played on registered scans."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8

from ..pictures import contact_sheet, label
from ..pictures.plot import bar_chart, line_chart
from ..pictures.render import Renderer
from ..pictures.show import rig_look
from ..pictures.view import frontal_camera
from ..progress import SILENT, Progress
from ..scans.reconstruct import ScanSolve
from ..scans.scan_rig import ScanRig
from .page import Report


def scan_preview(
    solved: ScanSolve, progress: Progress = SILENT, count: int = 8, size: int = 300
) -> UInt8[np.ndarray, "h w 3"]:
    """Frames that differ most, drawn on the rig."""
    performance = solved.performance
    rig, weights = performance.rig, performance.weights
    frames = _different(weights[:, : len(rig.names)], count)
    renderer = Renderer(rig.neutral, rig_look(rig.neutral), rig.texture)
    view, images = frontal_camera(rig.neutral, size, frame=_face(rig.neutral.vertices)), []
    for number, frame in enumerate(frames):
        image = renderer.draw(*view, vertices=rig.vertices(weights[frame]))
        images.append(label(image, f"{frame / performance.rate:.2f} s"))
        progress.update("drawing", number + 1, len(frames))
    return contact_sheet(images, columns=4)


def _face(vertices: np.ndarray) -> np.ndarray:
    """The front of a head in face space, for framing."""
    return vertices[(vertices[:, 2] > 40) & (np.abs(vertices[:, 1] + 20) < 95)]


def _different(weights: np.ndarray, count: int) -> list[int]:
    """Frames whose weights are farthest from one another, in order."""
    chosen = [int((weights**2).sum(axis=1).argmax())]
    away = ((weights - weights[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(count, len(weights)):
        chosen.append(int(away.argmax()))
        away = np.minimum(away, ((weights - weights[chosen[-1]]) ** 2).sum(axis=1))
    return sorted(chosen)


def scan_solve_report(
    name: str, solved: ScanSolve, scan_rig: ScanRig, picture: UInt8[np.ndarray, "h w 3"], notes: Sequence[str] = ()
) -> Report:
    """Picture, residuals by marker and over time, the weights that moved."""
    performance = solved.performance
    mixed, left = np.nanmean(solved.mixed), np.nanmean(solved.residuals)
    more = len(performance.rig.names) - len(scan_rig.rig.names)
    lead = (
        f"{len(performance)} frames at {performance.rate:g} a second on {len(scan_rig.expressions)} scans; mean "
        f"residual {mixed:.2f} mm, with {more} correctives {left:.2f} mm."
    )
    report = Report(f"{name}: markers to an animated face, by scans", lead)
    report.figure(picture, "Frames that differ most.")
    for note in notes:
        report.text(note)
    times = np.arange(len(performance)) / performance.rate
    every = max(1, len(times) // 1500)
    series = {
        "scans alone": (times[::every], _mean(solved.mixed)[::every]),
        "with correctives": (times[::every], _mean(solved.residuals)[::every]),
    }
    report.heading("Residual over time").chart(line_chart(series, "seconds", "mm"), "Mean over markers.")
    report.heading("Residual of every marker")
    means = dict(zip(solved.labels, _mean(solved.residuals.T).tolist(), strict=True))
    report.chart(bar_chart({n: m for n, m in means.items() if np.isfinite(m)}, x_label="mean, mm"))
    ranked = np.argsort(-performance.weights[:, : len(scan_rig.rig.names)].std(axis=0))[:6]
    lines = {performance.rig.names[k]: (times[::every], performance.weights[::every, k]) for k in ranked}
    return report.heading("Weights").chart(line_chart(lines, "seconds", "weight"), "The six scans that move most.")


def _mean(values: np.ndarray) -> np.ndarray:
    known = np.isfinite(values)
    count = known.sum(axis=1)
    return np.where(count > 0, np.nansum(values, axis=1) / np.maximum(count, 1), np.nan)
