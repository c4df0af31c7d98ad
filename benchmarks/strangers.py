"""Takes of people from another face model, solved by the documented commands and scored by their own script.

    python benchmarks/strangers.py [--only markers100 scans rgbd colour single ...] [--work FOLDER] [--json out.json]

The takes and their scoring script lie in `shared/strangers` beside the project, or where `--takes` says; where they are
not there, nothing is run. Prints every figure beside its goal; `work` keeps the outputs. Minutes a row.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mien.landmarks.detector import FaceLandmarker
from mien.rgbd import read_rgbd

MIEN = (sys.executable, "-c", "from mien.cli.main import main; main()")
"""The command of the tree that is imported, not the one that is installed."""
OPEN_MOUTH, OTHER_FRAME = "frame_000738", "frame_000186"
"""Two of the scans: correspondence is judged from one to the other."""
RESTING_SCAN = "frame_000001"
COLOUR_RATE = "30"
"""Frames a second of the colour images, which do not say."""


@dataclass(frozen=True)
class Goal:
    """What a row should come to, and how its figures are named; percents of the frozen baseline."""

    own: tuple[float, float] | None = None
    """Take, strongest tenth."""
    world: tuple[float, float] | None = None
    surface_mm: float | None = None
    wander_mm: float = 0.4
    weights_of_zeros: float = 0.5


HINTS = ("next:", "Blender keeps")
"""How the lines begin that say what to do next, not how well it went."""


@dataclass
class Run:
    """A folder of takes, a folder for outputs, and what was said on the way."""

    takes: Path
    work: Path
    said: list[str] = field(default_factory=list)

    def mien(self, *words: str | Path) -> bool:
        """Run one command; False if it stopped. Its last line is kept."""
        line = [*MIEN, *map(str, words)]
        begin = time.perf_counter()
        done = subprocess.run(line, capture_output=True, text=True)
        text = (done.stdout if done.returncode == 0 else done.stderr + done.stdout).strip().splitlines()
        of_the_result = [line for line in text if not line.startswith(HINTS)]
        self.said.append(f"mien {words[0]} ({time.perf_counter() - begin:.0f} s): {' '.join(of_the_result[-3:])}")
        return done.returncode == 0

    def score(self, script: str, *words: str | Path) -> dict:
        """What the takes' own script says, as it writes it."""
        out = self.work / "score.json"
        line = [sys.executable, script, *map(str, words), "--json", str(out)]
        subprocess.run(line, cwd=self.takes, check=True, capture_output=True)
        return json.loads(out.read_text())


def markers(run: Run, name: str) -> dict | None:
    """A marker take alone."""
    out = run.work / f"{name}.glb"
    if not run.mien("solve", run.takes / name / "take.c3d", "-o", out):
        return None
    return run.score("score.py", out, run.takes / name / "truth.npz")


def scans(run: Run) -> dict | None:
    """Scans registered to their take; the take solved on them."""
    folder, rig, out = run.takes / "markers100", run.work / "scan_rig.glb", run.work / "on_scans.glb"
    hints = ("--markers", folder / "take.c3d", "--selection", folder / "selection.json")
    if not run.mien("register", run.takes / "scans", *hints, "-o", rig):
        return None
    if not run.mien("solve", folder / "take.c3d", "--rig", rig, "-o", out):
        return None
    truth = run.takes / "truth_scans"
    pair = (f"{rig}#{OPEN_MOUTH}", truth / f"{OPEN_MOUTH}.npz", "--align", "rigid")
    other = ("--other", f"{rig}#{OTHER_FRAME}", truth / f"{OTHER_FRAME}.npz")
    return run.score("score.py", out, folder / "truth.npz") | {"scan": run.score("score_scan.py", *pair, *other)}


def rgbd(run: Run) -> dict | None:
    """Colour and depth: a rig of the calm second, then the take."""
    take, rig, out = run.takes / "rgbd" / "take", run.work / "rgbd_rig.glb", run.work / "rgbd.glb"
    if not run.mien("personalize", take, "-o", rig) or not run.mien("track", take, "--rig", rig, "-o", out):
        return None
    truth = run.takes / "rgbd" / "truth.npz"
    return run.score("score.py", out, truth) | {"mediapipe": mediapipe_error(take, truth)}


def mediapipe_error(take: Path, truth: Path) -> float:
    """Mean absolute error of MediaPipe's scores of a film's frames, as weights; zeros where it sees no face."""
    with FaceLandmarker("video") as eyes:
        seen = [eyes.detect(frame.color, frame.time) for frame in read_rgbd(take) if frame.color is not None]
    with np.load(truth) as known:
        said = [[marks.scores.get(str(name), 0.0) if marks else 0.0 for name in known["arkit_names"]] for marks in seen]
        return float(np.abs(np.array(said) - known["arkit"]).mean())


def colour(run: Run) -> dict | None:
    """The same film without its depth."""
    take, rig, out = run.takes / "rgbd" / "take" / "color", run.work / "colour_rig.glb", run.work / "colour.glb"
    if not run.mien("personalize", take, "-o", rig):
        return None
    if not run.mien("track", take, "--rig", rig, "--rate", COLOUR_RATE, "-o", out):
        return None
    return run.score("score.py", out, run.takes / "rgbd" / "truth.npz")


def single(run: Run) -> dict | None:
    """Two scans of one person, each registered by itself: how far apart the same vertex is on the skin."""
    found = {}
    for name in (RESTING_SCAN, OPEN_MOUTH):
        found[name] = run.work / f"{name}.glb"
        if not run.mien("register", run.takes / "scans" / f"{name}.ply", "-o", found[name]):
            return None
    truth = run.takes / "truth_scans"
    pair = (found[OPEN_MOUTH], truth / f"{OPEN_MOUTH}.npz", "--align", "rigid")
    return {"scan": run.score("score_scan.py", *pair, "--other", found[RESTING_SCAN], truth / f"{RESTING_SCAN}.npz")}


ROWS: dict[str, tuple[Callable[[Run], dict | None], Goal]] = {
    "markers100": (lambda run: markers(run, "markers100"), Goal(own=(40, 30), world=(25, 20))),
    "markers30": (lambda run: markers(run, "markers30"), Goal(own=(50, 40), world=(35, 30))),
    "scans": (scans, Goal(own=(30, 20), world=(15, 12))),
    "rgbd": (rgbd, Goal(own=(50, 35), world=(35, 30), surface_mm=0.5)),
    "colour": (colour, Goal(own=(70, 70), world=(60, 60))),
    "single": (single, Goal()),
}


def line(name: str, found: dict, goal: Goal) -> str:
    """One row of the table: take / strongest tenth (goal)."""
    if "table" not in found:
        return f"{name:12s}" + scan_line(found["scan"])
    take, strong = found["table"]["open"], found["table"]["strong"]
    cells = [f"{name:12s}"]
    for key, wanted in (("own", goal.own), ("ac", None), ("world", goal.world)):
        aim = f" ({wanted[0]:.0f} / {wanted[1]:.0f})" if wanted else ""
        cells.append(f"{take[key]:4.0f} / {strong[key]:.0f}{aim}".ljust(22))
    aim = f" ({goal.surface_mm})" if goal.surface_mm else ""
    cells.append(f"{take['surface_mm']:.2f}{aim}".ljust(12))
    cells.append(f"{found['wander_mm']:.2f} ({goal.wander_mm})".ljust(12))
    cells.append(weights_cell(found, goal))
    return " ".join(cells) + (f"\n{'':12s}" + scan_line(found["scan"]) if "scan" in found else "")


def weights_cell(found: dict, goal: Goal) -> str:
    """Mean absolute error of the ARKit weights beside that of all zeros, and of MediaPipe's scores."""
    if not (weights := found.get("weights")):
        return "no ARKit names"
    zeros = weights["of_zeros"]
    peers = f", MediaPipe {found['mediapipe']:.3f}" if "mediapipe" in found else ""
    return f"{weights['mean_abs_error']:.3f}, zeros {zeros:.3f} ({goal.weights_of_zeros * zeros:.3f}){peers}"


def scan_line(found: dict) -> str:
    """Surface and correspondence of registered scans."""
    return (
        f"scan: to the truth {found['to_truth_mm']['mean']:.2f} mm (p95 {found['to_truth_mm']['p95']:.2f}); "
        f"along the skin {found['tangential_mm']['mean']:.2f} mm (p95 {found['tangential_mm']['p95']:.2f})"
    )


def default_takes() -> Path | None:
    """`shared/strangers` beside the project or above it."""
    above = Path(__file__).resolve().parents[1:]
    return next((p / "shared" / "strangers" for p in above if (p / "shared" / "strangers").is_dir()), None)


def main() -> None:
    """Run the rows, print the table, write JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(ROWS), default=list(ROWS))
    parser.add_argument("--takes", type=Path, default=default_takes())
    parser.add_argument("--work", type=Path, help="keep the outputs here")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    if options.takes is None or not options.takes.is_dir():
        print("strangers: skipped, there is no folder shared/strangers (say --takes)")
        return
    with tempfile.TemporaryDirectory() as scratch:
        work = (options.work or Path(scratch)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        report = table(options.only, Run(options.takes.resolve(), work))
    if options.json:
        options.json.write_text(json.dumps(report, indent=1))


def table(names: list[str], run: Run) -> dict:
    """Run the rows and print each as it is done."""
    heads = ("own: take / tenth, %", "ac", "world", "surface, mm", "wander, mm", "weights' error")
    widths = (22, 22, 22, 12, 12, 0)
    print(" " * 13 + " ".join(h.ljust(w) for h, w in zip(heads, widths, strict=True)) + "  (goals in brackets)")
    report = {}
    for name in names:
        command, goal = ROWS[name]
        run.said.clear()
        found = command(run)
        print(line(name, found, goal) if found else f"{name:12s} stopped", flush=True)
        for said in run.said:
            print(f"{'':12s}   {said}", flush=True)
        report[name] = found
    return report


if __name__ == "__main__":
    main()
