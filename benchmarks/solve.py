"""Marker takes of the synthetic stage, solved and scored against the truth; prints a table and writes JSON.

    python benchmarks/solve.py [--json out.json] [--seeds 501 502] [--markers 100 30] [--kind stranger|bent]
"""

import argparse
import json
import os
import time

import numpy as np

from mien.faces import load_face
from mien.markers.pipeline import solve_take
from mien.stage import STRANGER, PerformerConfig, make_performer, marker_layout, perform, score_performance, scripted
from mien.stage.seeds import REPORTING_SEEDS
from mien.takes.frame_solve import solve_frames
from mien.takes.marker_model import marker_model
from mien.takes.stabilise import stabilise

KINDS = {"stranger": STRANGER, "bent": PerformerConfig()}
"""Moved by muscles of their own, or by the bundled shapes bent."""


def solve_one(seed: int, markers: int, seconds: float, rate: float, kind: str) -> dict:
    """One performer, one take, one row of figures."""
    performer = make_performer(seed, KINDS[kind])
    script = scripted(rate, seconds)
    take = perform(performer, script.weights, rate, marker_layout(performer, markers), seed=seed)
    begin = time.perf_counter()
    solved = solve_take(take.markers, load_face())
    whole_s = time.perf_counter() - begin
    score = score_performance(solved.performance, take.truth)
    strongest = score.strongest
    return {
        "kind": kind,
        "seed": seed,
        "markers": markers,
        "frames": len(script.weights),
        "marker_residual_mm": float(np.nanmean(solved.residuals)),
        "vertex_error_mm": float(score.absolute.mean()),
        "surface_error_mm": float(score.surface),
        "expression_error_mm": float(score.expression.mean()),
        "frozen_baseline_mm": float(score.frozen.mean()),
        "ratio": float(score.ratio),
        "ratio_strongest": float(score.expression[strongest].mean() / score.frozen[strongest].mean()),
        "alignment_margin": solved.calibration.alignment_margin,
        "weights_mae": float(np.abs(solved.performance.weights - script.weights).mean()),
        "zeros_mae": float(script.weights.mean()),
        "whole_s": whole_s,
        "frames_per_s": frame_rate(solved, take.markers),
    }


def frame_rate(solved, markers) -> float:
    """Frames a second of the frame solve: compiled, attachments known, poses from `stabilise`; median of three."""
    calibration = solved.calibration
    model = marker_model(calibration.rig, calibration.attachment, calibration.standoff)
    T_lab_face = stabilise(markers).T_lab_head @ calibration.T_face_head.inverse()
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        solve_frames(model, markers.positions, T_lab_face, markers.rate)
        times.append(time.perf_counter() - begin)
    return len(markers.positions) / float(np.median(times))


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", default=None)
    parser.add_argument("--seeds", type=int, nargs="+", default=list(REPORTING_SEEDS))
    parser.add_argument("--markers", type=int, nargs="+", default=[100, 30])
    parser.add_argument("--kind", choices=list(KINDS), default="stranger")
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--rate", type=float, default=60.0)
    options = parser.parse_args()
    settings = (options.seconds, options.rate, options.kind)
    rows = [solve_one(s, m, *settings) for m in options.markers for s in options.seeds]
    names = list(rows[0])
    widths = [max(len(n), 8) for n in names]
    print("  ".join(n.rjust(w) for n, w in zip(names, widths, strict=True)))
    for row in rows:
        cells = (f"{row[n]:.3f}" if isinstance(row[n], float) else str(row[n]) for n in names)
        print("  ".join(c.rjust(w) for c, w in zip(cells, widths, strict=True)))
    report = {"cores": os.cpu_count(), "rows": rows}
    print(json.dumps(report))
    if options.json:
        with open(options.json, "w") as file:
            json.dump(report, file, indent=1)


if __name__ == "__main__":
    main()
