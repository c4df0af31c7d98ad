"""Selection of the frames to scan, against the time that Huang et al. 2011 report; prints a table and JSON.

    python benchmarks/selection.py [--json out.json] [--frames 1500 13000] [--count 20]

Takes are those of the synthetic stage as a camera system gives them: 100 markers, 0.1 mm of jitter, 2 % drop-outs, a
moving head; stabilised and filled before the clock starts. The paper's 2-3 hours are for 1500 frames, about 100
markers and 20 expressions, in C++ on one 2.27 GHz Xeon E5520.
"""

import argparse
import json
import os
import time

import numpy as np
import scipy.optimize

from mien.scans.select.select_frames import SelectConfig, select_frames
from mien.stage import make_performer, marker_layout, perform, random_performance
from mien.takes.gaps import GapConfig, fill_gaps
from mien.takes.stabilise import stabilise

PAPER_S = (2 * 3600, 3 * 3600)
SECONDS = 54.2


def staged(frames: int, markers: int, seed: int) -> np.ndarray:
    """Marker positions (t, k, 3) in the head's frame, mm: 54 s of performance at the rate that gives so many frames."""
    rate = frames / SECONDS
    performer = make_performer(seed)
    script = random_performance(rate, SECONDS, seed)
    take = perform(performer, script.weights[:frames], rate, marker_layout(performer, markers), seed=seed)
    positions = stabilise(take.markers).markers.positions
    filled = fill_gaps(positions, rate, GapConfig(low_rank_s=np.inf))
    return filled[np.isfinite(filled).all(axis=(1, 2))]


def timed(positions: np.ndarray, count: int) -> dict:
    """One selection of `count` frames: figures, and how many would do by the paper's stop and by the default one."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    selection = select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=count))
    seconds, cpu = time.perf_counter() - begin, time.process_time() - begin_cpu
    below = selection.relative < SelectConfig.tolerance
    both = below & (selection.strongest < SelectConfig.strongest)
    return {
        "frames": len(positions),
        "markers": positions.shape[1],
        "chosen": len(selection.frames),
        "seconds": seconds,
        "cpu_s": cpu,
        "error_mm": float(selection.errors[-1]),
        "error_of_diagonal": float(selection.relative[-1]),
        "strongest_tenth": float(selection.strongest[-1]),
        "by_the_mean": first_count(below),
        "by_both": first_count(both),
        "paper_over_ours": PAPER_S[0] / seconds if positions.shape[0] <= 1500 else None,
    }


def first_count(met: np.ndarray) -> int | None:
    """How many frames it takes until a condition holds; None if it never does."""
    return int(np.argmax(met)) + 1 if met.any() else None


def agrees(positions: np.ndarray, count: int = 4) -> bool:
    """Whether algorithm 1 as printed, with scipy's NNLS for every frame and candidate, chooses the same frames."""
    X = (positions - positions.mean(axis=(0, 1))).reshape(len(positions), -1)
    chosen: list[int] = []
    while len(chosen) < count:
        costs = [
            np.inf if c in chosen else sum(scipy.optimize.nnls(X[[*chosen, c]].T, x)[1] ** 2 for x in X)
            for c in range(len(X))
        ]
        chosen.append(int(np.argmin(costs)))
    return select_frames(positions, SelectConfig(tolerance=1e-9, max_frames=count)).frames.tolist() == chosen


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", default=None)
    parser.add_argument("--frames", type=int, nargs="+", default=[1500, 13000])
    parser.add_argument("--markers", type=int, default=100)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    takes = [staged(frames, options.markers, options.seed) for frames in options.frames]
    same = agrees(takes[0][::25, ::4])
    rows = [timed(take, options.count) for take in takes]
    names = list(rows[0])
    print("  ".join(name.rjust(12) for name in names))
    for row in rows:
        cells = (f"{v:.4g}" if isinstance(v, float) else str(v if v is not None else "-") for v in row.values())
        print("  ".join(cell.rjust(max(12, len(name))) for cell, name in zip(cells, names, strict=True)))
    print(f"paper: 2-3 h for 1500 frames; same frames as brute force with scipy on a small take: {same}")
    report = {"cores": os.cpu_count(), "load": os.getloadavg()[0], "brute_force_agrees": same, "rows": rows}
    print(json.dumps(report))
    if options.json:
        with open(options.json, "w") as file:
            json.dump(report, file, indent=1)


if __name__ == "__main__":
    main()
