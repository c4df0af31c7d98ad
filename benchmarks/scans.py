"""A take and its scans to a performance at the size of Huang et al. 2011, against the times that they report.

    python benchmarks/scans.py [--json out.json] [--frames 1500] [--scans 20] [--density 2] [--seed 501] [--work FOLDER]

The stage gives 1500 frames of 100 markers (0.1 mm of jitter, 2 % drop-outs, a moving head) and a scan of 100,000
vertices for each of 20 selected frames (0.06 mm of noise, holes, a hair line, another rigid frame each, expressions
performed 0.5 mm off). The template is the bundled topology, 76,000 vertices at density 2. Prints times beside the
paper's (C++ on one 2.27 GHz Xeon E5520), then errors against the truth, which no step sees. Finished steps are kept in
`--work`, if given; what is read from there takes no time.
"""

import argparse
import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.faces import load_face
from mien.mesh import mass
from mien.reports.scans import surface_distances
from mien.rig import Rig
from mien.scans.pipeline import RegisteredScans, ScansConfig, register_scans
from mien.scans.reconstruct import ScanSolve, meet_markers, solve_on_scans, solve_weights
from mien.scans.select.select_frames import SelectConfig, select_frames
from mien.scans.select.take_selection import SelectTakeConfig, select_take
from mien.stage import ScanConfig, SkinConfig, make_performer, make_skin, marker_layout, perform, scan, scripted
from mien.stage.score_material import MaterialScore, material_under, scan_errors, score_material
from mien.stage.seeds import REPORTING_SEEDS
from mien.transforms import Transform

PAPER_S = {"selection": 2 * 3600, "registration": 5.2 * 3600}
WRINKLED_MM = 0.1
"""A vertex is wrinkled where its height above the smooth skin differs by this from the resting scan's."""


def staged(frames: int, count: int, seed: int):
    """The take, the selection with its time, and the scans."""
    skin = make_skin(make_performer(seed), SkinConfig(levels=3))
    rate = 60.0
    script = scripted(rate=rate, seconds=frames / rate, seed=seed)
    take = perform(skin, script.weights[:frames], rate, marker_layout(skin, 100), seed=seed)
    select = SelectConfig(tolerance=1e-9, max_frames=count)
    found = select_take(take.markers, SelectTakeConfig(select=select))
    begin = time.perf_counter()
    select_frames(found.positions, select)
    seconds = time.perf_counter() - begin
    chosen = found.selection.frames.tolist()
    scans = [
        scan(skin, script.weights[frame], ScanConfig(), seed=1000 * seed + i, name=f"frame_{frame:06d}")
        for i, frame in enumerate(chosen)
    ]
    return take, found, seconds, scans


def speeds(found: RegisteredScans, solved: ScanSolve, take) -> dict[str, float]:
    """Milliseconds a frame for the weights, frames a second for the mesh."""
    expressions, poses = found.scan_rig.expressions, solved.T_lab_face
    begin = time.perf_counter()
    solve_weights(expressions, take.markers.positions, poses)
    weights_ms = 1000 * (time.perf_counter() - begin) / len(take.markers.positions)
    rig, weights = found.scan_rig.rig, solved.performance.weights[:, : len(found.scans) - 1]
    begin = time.perf_counter()
    for frame in range(60):
        rig.vertices(weights[frame])
    return {"weights_ms_a_frame": weights_ms, "mesh_frames_per_s": 60 / (time.perf_counter() - begin)}


def correspondence(found: RegisteredScans, scans, layout) -> dict[str, float]:
    """Errors of attachments and of vertices against the truth, mm."""
    true = [next(s for s in scans if s.scan.name == placed.name) for placed in found.scans]
    rigid = [Transform(s.T_face_scan.rotation, s.T_face_scan.translation) for s in found.scans]
    skin = (found.template.regions["face"] > 0.5) & found.template.shown
    before, after = (scan_errors(list(x), rigid, true) for x in (found.coarse, found.fine.vertices))
    actor = true[0].truth.actor
    material, _ = material_under(actor, rigid[0].apply(true[0].truth.vertices), found.coarse[0])
    heights = np.stack([_carried(actor, material, s) for s in true])
    wrinkled = (np.abs(heights - heights[0]) > WRINKLED_MM) & skin
    attached = []
    for on, placed, T, s in zip(found.on_scans.scans, found.scans, rigid, true, strict=True):
        off = on.attachment.points(placed.mesh) - T.apply(s.truth.points(layout.attachment))
        attached.append(np.linalg.norm(off, axis=1)[on.covered])
    distances = surface_distances(found)[:, skin]
    known = distances[np.isfinite(distances)]
    return {
        "attachment_mm": float(np.concatenate(attached).mean()),
        "surface_mean_mm": float(known.mean()),
        "surface_p95_mm": float(np.quantile(known, 0.95)),
        "face_before_mm": float(before[1:, skin].mean()),
        "face_after_mm": float(after[1:, skin].mean()),
        "wrinkled_before_mm": float(before[wrinkled].mean()),
        "wrinkled_after_mm": float(after[wrinkled].mean()),
        "wrinkled_vertices": int(wrinkled.sum()),
    }


def _carried(actor, material, staged_scan) -> np.ndarray:
    """Height of wrinkles and pores under each vertex of the template, mm."""
    height = actor.height(staged_scan.truth.weights)
    return np.einsum("pc,pc->p", material.barycentric, height[actor.neutral.faces[material.faces]])


def performance_error(found: RegisteredScans, solved: ScanSolve, truth, correctives: bool = True) -> MaterialScore:
    """Over every third vertex of the face and every tenth frame."""
    rig, weights = solved.performance.rig, solved.performance.weights
    kept = len(rig.names) if correctives else len(found.scans) - 1
    skin = np.flatnonzero((found.template.regions["face"] > 0.5) & found.template.shown)[::3]
    some = found.template.members[skin]
    rest, deltas, used = rig.neutral.vertices[some], rig.deltas[:kept, some], weights[:, :kept]
    return score_material(
        vertices=lambda frame: rest + np.tensordot(used[frame], deltas, axes=1),
        T_lab_face=solved.T_lab_face,
        truth=truth,
        rest=found.scans[0].frame,
        frames=np.arange(0, len(truth), 10),
        areas=mass(rig.neutral.vertices, rig.neutral.faces)[some],
    )


def without_fine(found: RegisteredScans) -> RegisteredScans:
    """The same rig made of what the large-scale step left."""
    template, rig = found.template, found.scan_rig
    goals = rig.expressions
    skin = meet_markers(template.skin, found.coarse, found.attachment, goals, found.on_scans.standoff, found.covered)
    rest, *others = (template.whole(x) for x in skin)
    made = Rig(rig.rig.neutral.with_vertices(rest), np.stack(others) - rest, rig.rig.names)
    return replace(found, scan_rig=replace(rig, rig=made))


def main() -> None:
    """Stage, run, time, score."""
    parser = argparse.ArgumentParser(description="A take and its scans to a performance, timed and scored.")
    parser.add_argument("--frames", type=int, default=1500)
    parser.add_argument("--scans", type=int, default=20)
    parser.add_argument("--density", type=int, default=2)
    parser.add_argument("--seed", type=int, default=REPORTING_SEEDS[0])
    parser.add_argument("--work", type=Path)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    take, selected, selection_s, scans = staged(args.frames, args.scans, args.seed)
    print(f"load {os.getloadavg()[0]:.1f}; {len(scans)} scans of some {len(scans[0].scan.mesh.vertices)} vertices")
    config = ScansConfig(density=args.density)
    frames = selected.selection.frames.tolist()
    begin = time.perf_counter()
    found = register_scans(take.markers, [s.scan for s in scans], frames, load_face(), config, work=args.work)
    times = {"selection": selection_s, "registration": time.perf_counter() - begin}
    solved = solve_on_scans(take.markers, found.scan_rig)
    bare = without_fine(found)
    bare_solved = solve_on_scans(take.markers, bare.scan_rig)
    for name, seconds in times.items():
        paper = PAPER_S[name]
        print(f"{name:22s} {seconds:8.1f} s   paper {paper:6.0f} s   {paper / seconds:6.0f} x")
    figures = {"seconds": times, **speeds(found, solved, take)}
    figures |= correspondence(found, scans, take.truth)
    scores = {
        "performance": performance_error(found, solved, take.truth),
        "without correctives": performance_error(found, solved, take.truth, correctives=False),
        "without the fine step": performance_error(bare, bare_solved, take.truth),
        "without either": performance_error(bare, bare_solved, take.truth, correctives=False),
    }
    for name, score in scores.items():
        figures[name] = {"mm": float(score.error.mean()), "ratio": score.ratio, "strongest": score.ratio_strongest}
        ratios = f"{score.ratio:.0%} of frozen, strongest {score.ratio_strongest:.0%}"
        print(f"{name:22s} {score.error.mean():.3f} mm, {ratios}")
    figures["residual_mm"] = float(np.nanmean(solved.mixed))
    figures["residual_with_correctives_mm"] = float(np.nanmean(solved.residuals))
    for name, value in figures.items():
        if not isinstance(value, dict):
            print(f"{name:32s} {value:.3f}")
    if args.json:
        args.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
