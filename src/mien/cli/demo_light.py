"""`mien demo light`: clips of a staged, dotted face under active light, decoded, learnt from and synthesised."""

from dataclasses import replace
from pathlib import Path

import numpy as np

LEVELS, SIZE = 2, 192
"""Of the skin's subdivision; of the medium map, the fine one has twice as much."""


def demo_light(folder: Path, seed: int, dots: int) -> None:
    """Leaves takes/, clips/, maps/, scans.png, layers.png and report.html in `folder`."""
    from ..detail.disk.clips import read_training
    from ..detail.disk.maps import write_detail
    from ..detail.fit import DetailConfig, fit_detail
    from ..experiments.light_clips import LightClipsConfig, chain_errors, write_staged_takes
    from ..light.disk.training_clips import read_clip_takes, write_training_clips
    from ..stage import SkinConfig, make_performer, make_skin
    from .bar import bar

    plan = LightClipsConfig()
    plan = replace(plan, stage=replace(plan.stage, dots=dots))
    with bar() as progress:
        look = SkinConfig(levels=LEVELS, eyes_and_teeth=False)
        skin = make_skin(make_performer(seed), look, seed)
        truth = write_staged_takes(folder / "takes", skin, plan, seed, progress)
        takes, _ = read_clip_takes(folder / "takes")
        written = write_training_clips(folder / "clips", takes, progress=progress)
        whole, notes = read_training(folder / "clips")
        learnt = tuple(clip for clip in whole.clips if clip.name not in plan.unseen)
        others = tuple(clip for clip in whole.clips if clip.name in plan.unseen)
        training = replace(whole, clips=learnt)
        unseen = replace(whole, clips=others)
        sizes = DetailConfig(medium_size=SIZE, fine_size=2 * SIZE)
        model = fit_detail(training, sizes, progress)
        write_detail(folder / "maps", model, half=True)
        errors = chain_errors(model, whole, truth, written.T_face_rig)
    report(folder, model, training, unseen, errors, (*written.notes, *notes))
    print(f"{written.frames} captures, {len(whole.labels)} of {dots} dots are seen in all of them")
    for name, error in errors.items():
        told = f"scan {error.scan:.3f}  same points {error.again:.3f}  shell {error.shell:.3f}  full {error.full:.3f}"
        print(f"{name:12} {told}")
    print(f"{folder}/: takes/  clips/  maps/  scans.png  layers.png  report.html")


def report(folder: Path, model, training, unseen, errors, notes: tuple[str, ...]) -> None:
    """`scans.png`, `layers.png` and the page that shows both with the table of errors."""
    from ..experiments.detail_figures import last_frame, layers_sheet
    from ..pictures import write_png
    from ..reports.page import Report

    ends = [last_frame(training, clip) for clip in training.clips]
    shapes = [training.mesh.vertices, *(end.vertices for end in ends)]
    scans = scan_sheet(training, shapes)
    names = [clip.name for clip in training.clips]
    first, *_ = names
    rows = {first: (training, ends[0])}
    for clip in unseen.clips:
        end = last_frame(unseen, clip, model.head)
        rows[clip.name] = (unseen, end)
    layers = layers_sheet(model, rows)
    write_png(folder / "scans.png", scans)
    write_png(folder / "layers.png", layers)
    page = Report("Active light", "From patterns and gradients of light to scans, maps and synthesis (Ma et al. 2008).")
    page.heading("Scans").figure(scans, f"Decoded, in one texture space: neutral, {', '.join(names)}.")
    table = []
    for name, error in errors.items():
        table.append([name, error.scan, error.again, error.shell, error.full])
    page.heading("How near to the skin").table(table, COLUMNS, CAPTION)
    page.heading("From dots alone").figure(layers, "The last column is the decoded scan; the last row was not learnt.")
    page.text("\n\n".join(notes))
    page.write(folder / "report.html")


COLUMNS = ("clip", "scans, mm", "same points, mm", "shell alone, mm", "with maps, mm")
CAPTION = (
    "A clip's last frame: decoded scans to the true skin; their points to the same points of it; the dots' thin shell, "
    "and the shell with the maps that were learnt from the other clips' scans, to the true skin."
)


def scan_sheet(training, surfaces: list[np.ndarray]) -> np.ndarray:
    """Surfaces side by side, without what was not seen."""
    from ..experiments.detail_figures import shown_mesh
    from ..pictures import Renderer, contact_sheet, frontal_camera

    view = frontal_camera(training.mesh, 300)
    pictures = []
    for vertices in surfaces:
        shown = shown_mesh(vertices, training.mesh.faces)
        picture = Renderer(shown).draw(*view)
        pictures.append(picture)
    captions = ["neutral", *(clip.name for clip in training.clips)]
    return contact_sheet(pictures, captions, columns=len(pictures))
