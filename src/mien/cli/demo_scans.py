"""`mien demo scans`: a staged take and scans of its selected frames, registered, played and scored."""

from dataclasses import replace
from pathlib import Path

import numpy as np

SCANS = 6
"""Scans of the demonstration; the paper has about 20."""


def demo_scans(folder: Path, seed: int, seconds: float, count: int) -> None:
    """Leaves take.c3d, selection.json, scans/, rig.glb, perf.glb, preview.png, scans.png, report.html in `folder`."""
    from ..faces import load_face
    from ..io.gltf import write_performance, write_rig
    from ..io.markers import read_markers
    from ..pictures import write_png
    from ..reports.scan_solve import scan_preview
    from ..reports.scans import registered_sheet, scans_record, scans_report, surface_distances
    from ..scans.pipeline import ScansConfig, register_scans
    from ..scans.reconstruct import solve_on_scans
    from ..scans.scan_files import match_scans
    from ..scans.scan_rig import record_beside, write_record
    from ..scans.select.take_selection import read_selection
    from ..viewer.moving_page import moving_page
    from .bar import bar

    with bar() as progress:
        staged = stage(folder, seed, seconds, count, progress)
        recorded, config = read_markers(folder / "take.c3d"), ScansConfig(density=1)
        files, _ = match_scans(folder / "scans", read_selection(folder / "selection.json").frames)
        scans, frames = [replace(f.read(), name=f.name) for f in files], [f.frame for f in files]
        work = folder / "rig.work"
        found = register_scans(recorded, scans, frames, load_face(), config, work=work, progress=progress)
        distances = surface_distances(found)
        write_rig(folder / "rig.glb", found.scan_rig.rig)
        write_record(record_beside(folder / "rig.glb"), scans_record(found, distances, "take.c3d"))
        solved = solve_on_scans(recorded, found.scan_rig, progress=progress)
        write_performance(folder / "perf.glb", solved.performance)
        write_png(folder / "preview.png", scan_preview(solved, progress))
        write_png(folder / "scans.png", registered_sheet(found, distances))
        moving = moving_page(solved.performance, "perf.glb")
        against, rows, verdict = against_truth(staged, found, solved, recorded, frames, progress)
        report = scans_report("Markers and scans to a performance", found, distances, config, verdict, moving)
        report.folded("Against the truth", against).write(folder / "report.html")
    for row in rows:
        print("  ".join(str(cell) for cell in row))
    print(f"{folder}/: take.c3d  selection.json  scans/  rig.glb  perf.glb  preview.png  scans.png  report.html")


def stage(folder: Path, seed: int, seconds: float, count: int, progress):
    """A take of a performer with wrinkles, the frames to scan, and the scans; the truth of both."""
    from ..io.markers import read_markers, write_c3d
    from ..io.meshes import write_mesh
    from ..scans.select.select_frames import SelectConfig
    from ..scans.select.take_selection import SelectTakeConfig, select_take, write_selection
    from ..stage import ScanConfig, SkinConfig, make_performer, make_skin, marker_layout, perform, scan, scripted

    progress.update("staging a performance", 0, 2 + SCANS)
    skin = make_skin(make_performer(seed), SkinConfig(levels=2))
    script = scripted(rate=60.0, seconds=seconds)
    take = perform(skin, script.weights, 60.0, marker_layout(skin, count), seed=seed)
    write_c3d(folder / "take.c3d", take.markers)
    progress.update("staging a performance", 1, 2 + SCANS)
    chosen = SelectTakeConfig(select=SelectConfig(tolerance=1e-4, max_frames=SCANS))
    selected = select_take(read_markers(folder / "take.c3d"), chosen)
    write_selection(folder / "selection.json", "take.c3d", selected)
    (folder / "scans").mkdir(exist_ok=True)
    for old in (folder / "scans").glob("frame_*.ply"):
        old.unlink()
    scans = {}
    for number, frame in enumerate(selected.selection.frames.tolist()):
        name, settings = f"frame_{frame:06d}", ScanConfig(vertices=50_000)
        scans[name] = scan(skin, script.weights[frame], settings, seed=1000 * seed + number, name=name)
        write_mesh(folder / "scans" / f"{name}.ply", scans[name].scan.mesh)
        progress.update("staging a performance", 3 + number, 2 + SCANS)
    return take.truth, scans


def against_truth(staged, found, solved, recorded, frames, progress):
    """Correspondence errors before and after the fine-scale step, the performance's, and the paper's fig. 8.

    Returns a report, its rows, and the verdict.
    """
    from ..pictures.plot import line_chart
    from ..reports.page import Report
    from ..reports.verdict import truth_verdict
    from ..stage.score_material import scan_errors
    from ..transforms import Transform

    truth, scans = staged
    shown = (found.template.regions["face"] > 0.5) & found.template.shown
    rigid = [Transform(s.T_face_scan.rotation, s.T_face_scan.translation) for s in found.scans]
    true = [scans[s.name] for s in found.scans]
    before, after = (scan_errors(x, rigid, true)[1:, shown].mean() for x in (found.coarse, found.fine.vertices))
    score = scored(solved, found, truth, shown, 6)
    rows = [
        ("vertices of scans to their true places, large-scale step", f"{before:.3f} mm", "", ""),
        ("... and after the fine-scale step", f"{after:.3f} mm", "", f"{after / before:.0%}"),
        *score.rows(),
    ]
    report = Report("").text(
        "Errors are distances between each vertex and the skin that it covers at rest. The frozen baseline is the "
        "right person in the right pose with one fixed mean expression."
    )
    report.table(rows, ("", "result", "frozen", "ratio"))
    numbers, at_markers, at_mesh = by_number_of_scans(found, recorded, truth, shown, frames, progress)
    series = {"markers": (numbers, at_markers), "full mesh": (numbers, at_mesh)}
    report.heading("How many scans").chart(
        line_chart(series, "scans", "mean error, mm"), "Error against the number of scans, correctives off (fig. 8)."
    )
    return report, rows, truth_verdict(score.ratio, score.ratio_strongest)


def scored(solved, found, truth, shown, step: int):
    """Errors of every third vertex of the face, every `step` frames."""
    from ..mesh import mass
    from ..stage.score_material import score_material

    rig, weights = solved.performance.rig, solved.performance.weights
    some = found.template.members[np.flatnonzero(shown)[::3]]
    rest, deltas = rig.neutral.vertices[some], rig.deltas[:, some]
    return score_material(
        vertices=lambda frame: rest + np.tensordot(weights[frame], deltas, axes=1),
        T_lab_face=solved.T_lab_face,
        truth=truth,
        rest=found.scans[0].frame,
        frames=np.arange(0, len(truth), step),
        areas=mass(rig.neutral.vertices, rig.neutral.faces)[some],
    )


def by_number_of_scans(found, recorded, truth, shown, frames, progress):
    """Mean errors at the markers and over the face with the first 2, 3, ... of the selected scans (fig. 8)."""
    from ..rig import Rig
    from ..scans.reconstruct import ReconstructConfig, solve_on_scans

    whole = found.scan_rig
    order = [name for frame in frames for name in whole.rig.names if name.endswith(f"{frame:06d}")]
    numbers, at_markers, at_mesh = [], [], []
    for k in range(1, len(order) + 1):
        used = [whole.rig.index(name) for name in order[:k]]
        rig = Rig(whole.rig.neutral, whole.rig.deltas[used], tuple(order[:k]))
        part = replace(whole, rig=rig, expressions=whole.expressions[[0, *(1 + i for i in used)]])
        solved = solve_on_scans(recorded, part, ReconstructConfig(correctives=0))
        numbers.append(k + 1)
        at_markers.append(float(np.nanmean(solved.mixed)))
        at_mesh.append(float(scored(solved, found, truth, shown, 24).error.mean()))
        progress.update("with fewer scans", k, len(order))
    return np.array(numbers), np.array(at_markers), np.array(at_mesh)
