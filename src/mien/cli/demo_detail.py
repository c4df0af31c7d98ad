"""`mien demo detail`: a staged subject's wrinkles are learnt, played on unseen clips, and drawn as figures."""

from dataclasses import replace
from pathlib import Path

import numpy as np

FRAMES, LEVELS, SIZE = 6, 2, 192
"""Of a training clip; of the skin's subdivision; of the medium map, the fine one has twice as much."""
DOT_MM = 1.5
"""Radius of the dots in the colours."""
CHEEK_MM = np.array([34.0, 6.0, -28.0])
"""From the tip of the nose to the left cheek."""
ORDERS = {"linear": 1, "biquadratic": 2, "bicubic": 3}
PAPER = {"energies": (76.84, 92.52, 98.46, 99.76, 100.0), "medium": (0.397, 0.303, 0.296)}
"""Table 1, per cent; figure 5, mm."""


def demo_detail(folder: Path, seed: int, markers: int) -> None:
    """Leaves maps/, page/, figures 3 to 8 and report.html in `folder`."""
    from ..detail.disk.maps import write_detail
    from ..detail.fit import DetailConfig, fit_detail
    from ..detail.reflectance import ReflectanceConfig
    from ..experiments.detail_stage import DetailStageConfig, detail_stage, kept_in_memory
    from ..experiments.detail_study import placement_errors
    from .bar import bar

    config = DetailConfig(medium_size=SIZE, fine_size=2 * SIZE)
    with bar() as progress:
        before = DetailStageConfig(
            markers=markers, levels=LEVELS, frames=FRAMES, dot_radius_mm=DOT_MM, eyes_and_teeth=True
        )
        stage = detail_stage(seed, before)
        training = kept_in_memory(stage.training)
        unseen = kept_in_memory(stage.unseen)
        stage = replace(stage, training=training, unseen=unseen)
        models = {}
        for name, order in ORDERS.items():
            with_order = _with_order(config, order)
            models[name] = fit_detail(training, with_order, progress)
        by_strain = replace(config.domain, offsets=False)
        strain = replace(config, fine_size=0, domain=by_strain, reflectance=ReflectanceConfig(learn=False))
        models["strain"] = fit_detail(stage.training, strain, progress)
        write_detail(folder / "maps", models["biquadratic"], half=True)
        play_unseen(folder / "page", stage, models["biquadratic"])
        figures = draw_figures(stage, models)
        placed = {name: shown for name, *shown in placement_errors(stage, models["biquadratic"])}
        errors = report(folder, stage, models, figures, placed)
    for row in errors:
        print(f"{row[0]:12}", *(f"{value:8.4f}" for value in row[1:]))
    print(f"{folder}/: maps/  page/index.html  figure_3.png to figure_8.png  report.html")


def play_unseen(folder: Path, stage, model) -> None:
    """The clips that were not trained on, one after another, evaluated in a browser."""
    from ..clip import Markers
    from ..detail.drive import drive_by_markers
    from ..experiments.detail_stage import RATE
    from ..viewer.detail_page import write_detail_page

    positions = np.concatenate([clip.markers for clip in stage.unseen.clips])
    take = Markers(positions, model.labels, RATE)
    write_detail_page(folder, model, drive_by_markers(model, take), RATE)


def _with_order(config, order: int):
    medium = replace(config.medium, order=order)
    fine = replace(config.fine, order=order)
    return replace(config, medium=medium, fine=fine)


def draw_figures(stage, models) -> dict[str, np.ndarray]:
    """Figures 3 to 8, by number."""
    from ..detail.base_mesh import BaseConfig, base_mesh
    from ..detail.sampling import sampler
    from ..experiments import detail_figures as draw

    model = models["biquadratic"]
    base = base_mesh(stage.training.mesh, BaseConfig())
    seen = {clip.name: draw.last_frame(stage.training, clip) for clip in stage.training.clips}
    other = {clip.name: draw.last_frame(stage.unseen, clip, model.head) for clip in stage.unseen.clips}
    medium = sampler(stage.training, base, model.shell, model.medium.texels.size, np.inf)
    fine = sampler(stage.training, base, model.shell, model.fine.texels.size, np.inf)
    skin = stage.training.mesh.vertices
    cheek = skin[_cheek(skin)]
    rows = {
        "anger": (stage.training, seen["anger"]),
        "asymmetric": (stage.unseen, other["asymmetric"]),
    }
    orders = {name: models[name] for name in ORDERS}
    return {
        "3": draw.deformation_fields(model, stage.training),
        "4": draw.strain_sheet(model, models["strain"], stage.unseen, other["speech"]),
        "5": draw.error_sheet(orders),
        "6": draw.map_sheet(model, medium, fine, seen["happy"]),
        "7": draw.pore_sheet(model, stage.training, seen["happy"], cheek),
        "8": draw.layers_sheet(model, rows),
        "reflectance": draw.color_sheet(model, stage.training, seen["happy"]),
    }


def _cheek(vertices: np.ndarray) -> int:
    """A vertex of the left cheek, beside the nose and below the eye."""
    top = vertices[vertices[:, 2].argmax()]
    away = vertices - top - CHEEK_MM
    return int((away**2).sum(axis=1).argmin())


def report(folder: Path, stage, models, figures, placed: dict[str, list[float]]) -> list[list]:
    """Figures as files, `report.html`, and the table of errors; `placed`: those of markers elsewhere, mm."""
    from ..experiments.detail_stage import detail_errors
    from ..pictures import write_png
    from ..pictures.plot import bar_chart
    from ..reports.page import Report

    page = Report("Detail from markers", "Displacement maps that are polynomials of the deformation (Ma et al. 2008).")
    errors, markers = [], len(stage.training.labels)
    for part in (stage.training, stage.unseen):
        for name, e in detail_errors(models["biquadratic"], part).items():
            errors.append([name, e.frozen, e.shell, e.medium, e.full])
    page.heading("How near to the skin").table(
        errors, ("clip", "static map, mm", "shell alone, mm", "+ medium, mm", "+ fine, mm"),
        "Mean distance to the true skin, point by point; the last three clips were never trained on.",
    )  # fmt: skip
    ours = [100 * e for e in models["biquadratic"].domain.energies]
    page.heading("Table 1: deformation held by 1 to 5 directions, %").table(
        [["ours", *ours], ["paper", *PAPER["energies"]]], ("", "1", "2", "3", "4", "5")
    )
    left = [_residual(models[name].medium) for name in ORDERS]
    page.heading("Residual of the medium map on its training, mm").table(
        [["ours", *left], ["paper", *PAPER["medium"]]], ("", *ORDERS)
    )
    chart = bar_chart(placed, ("shell alone", "with both maps"), "mm from the true skin")
    page.heading("Markers elsewhere").chart(chart, f"Clips not trained on, under maps of {markers} markers.")
    for number, (title, caption) in CAPTIONS.items():
        write_png(folder / f"figure_{number}.png", figures[number])
        page.heading(f"Figure {number}: {title}" if number.isdigit() else title).figure(figures[number], caption)
    page.write(folder / "report.html")
    return errors


def _residual(detail) -> float:
    """Mean rms of the reliable texels, mm."""
    reliable = detail.error[~detail.unreliable]
    return float(np.nanmean(reliable))


CAPTIONS = {
    "3": ("the fields that drive the maps", "Extremes of the training clips; d1 and d2 from -2 (blue) to 2 (red)."),
    "4": ("offsets beside strain", "A frame of speech, which was not trained on."),
    "5": ("errors by order", "What the maps leave of the training data, rms, in texture space."),
    "6": ("maps against the truth", "The extreme of `happy`: heights along the normal."),
    "7": ("pores that stretch", "A cheek at the extreme of `happy`."),
    "8": ("the layers", "A trained frame, and one with an asymmetry that no clip showed."),
    "reflectance": ("Reflectance", "The extreme of `happy`: black dots in the colours, and none in what was learnt."),
}
