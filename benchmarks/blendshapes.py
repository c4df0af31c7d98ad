"""Textured blendshapes against the truth, beside simpler ways, on several kinds of people (Casas et al. 2016).

    python benchmarks/blendshapes.py [--kind bent] [--only jawOpen,smile] [--frames 24] [--seed 1] [--json out.json]
    python benchmarks/blendshapes.py --grades
    python benchmarks/blendshapes.py --growth
    python benchmarks/blendshapes.py --headset --seed 501
    python benchmarks/blendshapes.py --kind stranger [--folder ../shared/strangers]

A staged person (`bent`: bundled shapes bent; `muscles`: motion the bundled shapes do not know) holds expressions before
a structured-light sensor and turns the head; `stranger` takes scans of another generator as photogrammetry would give
them, without colour. Errors are distances between each artist vertex and the place where the truth has the same skin,
mm: mean, median, 95th percentile over the face; drift is in texels of a 1024^2 texture; the last column is the mean
beyond 60 degrees from the front. Every way has its head held still by the same step. `--grades` compares sensors by
their neutral scans, `--growth` tells seconds by texture size and captures, `--headset` how a face is driven whose upper
part is hidden (a staged session, 15 s of calibration and 4 s with the headset on). Seconds are of processor time; the
paper needs about 20 s a scan with its capture, and 60 s a blendshape with a GPU's flow.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.blendshapes.align import align
from mien.blendshapes.assemble import completed, with_masks
from mien.blendshapes.captures import capture_of_mesh
from mien.blendshapes.correspond.landmarks import landmarks_on_map
from mien.blendshapes.expression import RigConfig, build_shape, neutral_face
from mien.blendshapes.scan.pipeline import FusionConfig, scan_take
from mien.experiments.blendshapes_score import true_skin
from mien.experiments.blendshapes_stage import (
    EXPRESSIONS,
    GRADES,
    CaptureStageConfig,
    capture_actor,
    capture_weights,
    graded,
    single_frames,
    staged_capture,
)
from mien.experiments.blendshapes_ways import errors_of, ways
from mien.experiments.hidden_face import HiddenFaceConfig, hidden_errors, hidden_face, lower_skin
from mien.faces import load_face
from mien.io.meshes import read_scan
from mien.landmarks.detector import FaceLandmarker
from mien.landmarks.lift import lift_landmarks
from mien.mesh import ClosestPoint, Mesh
from mien.stage import STRANGER, PerformerConfig, make_performer

PAPER_S = {"a fused scan": 20, "a blendshape": 60}
SIZES, COUNTS = (512, 1024, 2048), (1, 2, 4)
NEUTRAL, GREY, NEAR_MM = "frame_000001", 0.6, 1.0
"""The strangers' neutral scan; the colour that they are given; vertices nearer to the truth than this are scored."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=["bent", "muscles", "stranger"], default="bent")
    parser.add_argument("--only", help="expressions, or scans of strangers, with commas between; all where not given")
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--grades", action="store_true")
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--headset", action="store_true")
    parser.add_argument("--folder", type=Path, default=Path("../shared/strangers"))
    parser.add_argument("--json")
    args = parser.parse_args()
    if args.kind == "stranger":
        found = strangers(args)
    elif args.grades:
        found = grades(args)
    elif args.growth:
        found = growth(args)
    elif args.headset:
        found = headset(args)
    else:
        found = staged(args)
    if args.json:
        with open(args.json, "w") as file:
            json.dump(found, file, indent=1)


class Scanner:
    """A person's session, and the seconds that its parts took."""

    def __init__(self, args, **more):
        person = STRANGER if args.kind == "muscles" else PerformerConfig()
        self.config = replace(CaptureStageConfig(frames=args.frames, person=person), **more)
        self.seed, self.actor = args.seed, capture_actor(args.seed, self.config)
        self.landmarker = FaceLandmarker()
        self.seconds = {name: [] for name in PAPER_S}

    def film(self, name: str):
        """(the staged film, its frames made)."""
        staged = staged_capture(self.actor, name, self.seed, self.config)
        return staged, list(staged.take)

    def scan(self, name: str):
        """One expression's map."""
        staged, frames = self.film(name)
        return self.fused(replace(staged.take, name=name, frames=lambda: iter(frames)))

    def fused(self, take):
        """A take's map."""
        begun = time.process_time()
        map_ = scan_take(take, landmarker=self.landmarker).map
        self.seconds["a fused scan"].append(time.process_time() - begun)
        return map_


def staged(args) -> dict:
    """Every way's errors on the stage."""
    scanner, face = Scanner(args), load_face()
    neutral = neutral_face(scanner.scan("neutral"), face, RigConfig())
    truth = true_skin(scanner.actor, neutral.map, neutral.artist)
    print(f"neutral: {truth.neutral_mm:.3f} mm from the true surface, mean", flush=True)
    table = {}
    for name in (args.only or ",".join(EXPRESSIONS)).split(","):
        if name == "neutral":
            continue
        map_ = scanner.scan(name)
        begun = time.process_time()
        build_shape(map_, neutral, face, RigConfig())
        scanner.seconds["a blendshape"].append(time.process_time() - begun)
        aligned = align(map_, landmarks_on_map(map_), neutral.map, neutral.landmarks)
        found = ways(aligned, neutral, face)
        weights = capture_weights(name)
        table[name] = {way: errors_of(p, truth, weights, neutral, face) for way, p in found.items()}
        told(name, table[name])
    told("all", averages(table))
    for name, spent in scanner.seconds.items():
        mean = float(np.mean(spent))
        print(f"{name}: {mean:.1f} s of processor time; paper about {PAPER_S[name]} s ({mean / PAPER_S[name]:.2f})")
    return {"neutral_mm": truth.neutral_mm, "errors": table, "seconds": scanner.seconds}


def told(name: str, rows: dict[str, dict[str, float]]) -> None:
    """One expression's lines."""
    for way, row in rows.items():
        values = "  ".join(f"{value:6.2f}" for value in row.values())
        print(f"{name:12} {way:24} {values}", flush=True)


def averages(table: dict) -> dict[str, dict[str, float]]:
    """Each way's figures, averaged over the expressions."""
    rows = list(table.values())
    return {way: {key: float(np.mean([row[way][key] for row in rows])) for key in rows[0][way]} for way in rows[0]}


def grades(args) -> dict:
    """The neutral scan of each grade of sensor beside its best single frame, mm."""
    found = {}
    for name, grade in GRADES.items():
        scanner = Scanner(args, film=graded(grade))
        staged, frames = scanner.film("neutral")
        map_ = scanner.fused(replace(staged.take, name="neutral", frames=lambda kept=frames: iter(kept)))
        neutral = neutral_face(map_, load_face(), RigConfig(texture=SIZES[0]))
        truth = true_skin(scanner.actor, neutral.map, neutral.artist)
        best = min(single_frames(staged, frames))
        found[name] = {"fused": truth.neutral_mm, "best frame": best}
        print(f"{name:10} fused {truth.neutral_mm:.3f} mm, best single frame {best:.3f} mm", flush=True)
    return found


def growth(args) -> dict:
    """Seconds of a blendshape by texture size, and of completing the 52 shapes by captures."""
    scanner, face, found = Scanner(args), load_face(), {}
    calm, jaw = scanner.scan("neutral"), scanner.scan("jawOpen")
    for size in SIZES:
        config = RigConfig(texture=size)
        neutral = neutral_face(calm, face, config)
        begun = time.process_time()
        shape = build_shape(jaw, neutral, face, config)
        found[f"texture {size}"] = time.process_time() - begun
        for count in COUNTS if size == SIZES[0] else ():
            shapes = [replace(shape, name=f"capture_{i}") for i in range(count)]
            begun = time.process_time()
            completed(with_masks(neutral, shapes, face, config), neutral, shapes, face, config)
            found[f"captures {count}"] = time.process_time() - begun
    for name, seconds in found.items():
        print(f"{name:14} {seconds:.2f} s of processor time")
    return found


def headset(args) -> dict:
    """Weights of upper and lower shapes, and the lower face's moved skin, beside a face that does not move."""
    session = hidden_face(make_performer(args.seed), args.seed, HiddenFaceConfig(each_s=0.6, seconds=4.0))
    found = hidden_errors(session)
    for part, row in found.items():
        told_row = ", ".join(f"{way} {value:.3f}" for way, value in row.items())
        print(f"{part} shapes, rms error of weights: {told_row}")
    moved, frozen = lower_skin(session)
    print(f"lower skin {moved:.2f} mm from the true one, of a frozen face {frozen:.2f} mm ({moved / frozen:.0%})")
    return {"weights": found, "lower skin": {"ours": moved, "frozen": frozen}}


def strangers(args) -> dict:
    """Scans of another generator, in grey: shape errors by its own correspondence; no colour, so no drift."""
    if not (args.folder / "scans").is_dir():
        raise SystemExit(f"{args.folder}: no scans of strangers there; give --folder")
    face = load_face()
    calm, T_calm = stranger(args.folder, NEUTRAL)
    neutral = neutral_face(calm, face, RigConfig(texture=SIZES[0]))
    true = np.load(args.folder / "truth_scans" / f"{NEUTRAL}.npz")
    rest = Mesh(T_calm.apply(true["vertices"]), true["faces"].astype(np.int64))
    near = ClosestPoint(rest).query(neutral.artist.mesh.vertices)
    scored = neutral.artist.shown & (near.distances < NEAR_MM) & (face.regions["face"] > 0.5)
    table = {}
    others = sorted(p.stem for p in (args.folder / "scans").iterdir() if p.stem != NEUTRAL)
    for name in others if args.only is None else args.only.split(","):
        map_, T_face_scan = stranger(args.folder, name)
        aligned = align(map_, landmarks_on_map(map_), neutral.map, neutral.landmarks)
        moved = np.load(args.folder / "truth_scans" / f"{name}.npz")["vertices"]
        placed = rest.with_vertices((aligned.T_neutral_capture @ T_face_scan).apply(moved))
        goal, table[name] = near.attachment().points(placed), {}
        for way, points in ways(aligned, neutral, face).items():
            off = np.linalg.norm(points - goal, axis=1)[scored & np.isfinite(points[:, 0])]
            told_off = {"mean": off.mean(), "median": np.median(off), "p95": np.quantile(off, 0.95)}
            table[name][way] = {key: float(value) for key, value in told_off.items()}
        told(name, table[name])
    told("all", averages(table))
    return {"errors": table}


def stranger(folder: Path, name: str):
    """(map, T_face_scan) of a scan."""
    scan = read_scan(folder / "scans" / f"{name}.ply")
    grey = np.full((len(scan.mesh.vertices), 3), GREY)
    scan = replace(scan, mesh=replace(scan.mesh, colors=grey))
    placed = lift_landmarks(scan).T_face_scan
    return capture_of_mesh(scan, FusionConfig().pixel_mm).map.named(name), placed


if __name__ == "__main__":
    main()
