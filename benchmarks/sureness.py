"""Do the figures that a solve prints know its true error? Rank correlations over many staged takes.

    python benchmarks/sureness.py [--takes 20] [--tuning] [--markers 100 60 30] [--seconds 8] [--restless]
        [--elsewhere FOLDER] [--json out.json]

Performers of both kinds (reporting seeds, or with `--tuning` those that choices are made on, in turn: moved by muscles,
by the bundled shapes bent) with the faults of uncleaned takes, the numbers of markers in turn. Every number that the
result carries is tried; 1 or -1 would know the order of the takes exactly, and 0.7 is wanted of one of them. Takes of
people from another face model, where they lie in `shared/strangers` beside the project or where `--elsewhere` says,
count too, scored by their own script. `--restless` cuts takes out of a longer performance where it comes least to rest.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path

import numpy as np
from strangers import default_takes

from mien.errors import BadInput
from mien.faces import load_face
from mien.faces.arkit import ARKIT_NAMES
from mien.io.gltf import write_performance
from mien.io.markers import read_markers
from mien.markers.pipeline import TakeSolve, solve_take
from mien.stage import (
    STRANGER,
    MocapConfig,
    PerformerConfig,
    make_performer,
    marker_layout,
    perform,
    random_performance,
    rank_correlation,
    score_performance,
)
from mien.stage.seeds import MANY_REPORTING_SEEDS, TUNING_SEEDS

RATE = 60.0
WHOLE_S = 30.0
"""Length of a performance that restless takes are cut out of."""
GOAL = 0.7
KINDS = {"muscles": STRANGER, "bent": PerformerConfig()}
"""In turn: moved by muscles of their own, or by the bundled shapes bent."""
FAULTS = {
    "clean": MocapConfig(),
    "noisy": MocapConfig(jitter=0.3, lost=1),
    "mislabelled": MocapConfig(dropouts=0.05, swaps=1, ghosts=2),
}
"""In turn: a clean take, a noisy one, one with wrong labels."""

ELSEWHERE = ("markers100", "markers30")
"""Marker takes of people from another face model."""


def figures(solved: TakeSolve) -> dict[str, float]:
    """Every number of the result and of its parts, what they come to together, and the mean of its residuals."""
    found = {"expected_share": solved.left_out.expected_share, "neutral_added": solved.calibration.neutral.added}
    for part in (solved, *(getattr(solved, f.name) for f in fields(solved) if is_dataclass(getattr(solved, f.name)))):  # type: ignore
        for f in fields(part):
            value = getattr(part, f.name)
            if isinstance(value, float | np.floating):
                found[f.name] = float(value)
            elif f.name == "residuals":
                found["residual"] = float(np.nanmean(value))
    return found


def performed(seconds: float, seed: int) -> np.ndarray:
    """Weights of an ordinary take, (frames, 52)."""
    return random_performance(RATE, seconds, seed).weights


def restless(seconds: float, seed: int) -> np.ndarray:
    """Weights of the piece of a performance that comes least to rest, (frames, 52): its calmest frame has the most."""
    whole = random_performance(RATE, WHOLE_S, seed).weights
    length = int(seconds * RATE)
    active = whole[:, [not name.startswith("eye") for name in ARKIT_NAMES]].sum(axis=1)
    starts = np.arange(0, len(whole) - length, int(RATE / 4))
    first = max(starts, key=lambda start: active[start : start + length].min())
    return whole[first : first + length]


def one(seed: int, markers: int, kind: PerformerConfig, faults: MocapConfig, weights: np.ndarray) -> dict[str, float]:
    """One take: its printed figures and its true error."""
    performer = make_performer(seed, kind)
    take = perform(performer, weights, RATE, marker_layout(performer, markers), faults, seed)
    solved = solve_take(take.markers, load_face())
    score = score_performance(solved.performance, take.truth, step=4)
    true = {
        "true_mm": float(score.absolute.mean()),
        "true_expression_mm": float(score.expression.mean()),
        "true_ratio": float(score.ratio),
    }
    return figures(solved) | true


def from_elsewhere(folder: Path) -> dict[str, float]:
    """A take of a person from another face model: expression from each face's own neutral, as on the stage."""
    solved = solve_take(read_markers(folder / "take.c3d"), load_face())
    with tempfile.TemporaryDirectory() as scratch:
        played, report = Path(scratch) / "played.glb", Path(scratch) / "score.json"
        write_performance(played, solved.performance)
        script = (sys.executable, "score.py", played, folder / "truth.npz", "--json", report)
        subprocess.run([str(word) for word in script], cwd=folder.parent, check=True, capture_output=True)
        face = json.loads(report.read_text())["table"]["open"]
    ratio = face["own"] / 100
    true = {"true_mm": float("nan"), "true_expression_mm": ratio * face["moved_mm"], "true_ratio": ratio}
    return figures(solved) | true


SHOWN = (
    "expected_share",
    "left_out_share",
    "neutral_added",
    "residual",
    "true_ratio",
    "true_expression_mm",
    "true_mm",
)
"""What the table says of each take."""


def shown(case: str, make: Callable[[], dict]) -> list[dict]:
    """A line of the table and its row; none, and why, where the take is refused."""
    try:
        row = make()
    except BadInput as refused:
        print(f"{case}: refused: {refused}")
        return []
    print(f"{case:40s}" + "".join(f"{row[name]:>20.3f}" for name in SHOWN), flush=True)
    return [{"case": case} | row]


def main() -> None:
    """Run, print the correlations, write JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--takes", type=int, default=len(MANY_REPORTING_SEEDS))
    parser.add_argument("--markers", type=int, nargs="+", default=[100, 60, 30])
    parser.add_argument("--tuning", action="store_true")
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--restless", action="store_true")
    parser.add_argument("--elsewhere", type=Path, default=default_takes())
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    folders = [options.elsewhere / name for name in ELSEWHERE] if options.elsewhere else []
    print(f"{'take':40s}" + "".join(f"{name:>20s}" for name in SHOWN))
    rows = []
    for folder in filter(Path.is_dir, folders):
        rows += shown(f"from elsewhere, {folder.name}", partial(from_elsewhere, folder))
    seeds = TUNING_SEEDS if options.tuning else MANY_REPORTING_SEEDS
    for i, seed in enumerate(seeds[: options.takes]):
        markers = options.markers[i % len(options.markers)]
        kind, faults = list(KINDS)[seed % len(KINDS)], list(FAULTS)[i // 2 % len(FAULTS)]
        case = f"{seed}, {kind}, {markers} markers, {faults}"
        script = restless if options.restless else performed
        weights = script(options.seconds, seed)
        rows += shown(case, partial(one, seed, markers, KINDS[kind], FAULTS[faults], weights))
    for name in sorted({n for row in rows for n in row if n != "case" and not n.startswith("true")}):
        printed = np.array([row.get(name, np.nan) for row in rows])
        against = {t: rank_correlation(printed, np.array([row[t] for row in rows])) for t in rows[0] if "true" in t}
        told = ", ".join(f"{t.removeprefix('true_')} {r:+.2f}" for t, r in against.items())
        print(f"{name:24s} rank correlation with the true error over {len(rows)} takes: {told} (wanted: {GOAL})")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
