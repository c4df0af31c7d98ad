"""Nonrigid registration against MeshMonk 0.3.0 (PyPI); prints a table and JSON.

    python benchmarks/register.py [--json out.json] [--data FOLDER] [--only real|stage] [--actors 2]

MeshMonk is installed into a throw-away environment and runs in a process of its own; only the registration itself is
timed, on both sides. Both start from the same rigidly placed template and are told nothing else. Pairs: MeshMonk's own
template and face at about 10,000 and 40,000 vertices (skipped where the recordings are not there), and scans of the
synthetic stage, where the true place of each vertex is known. There the last row is the whole of `mien register`, with
its own landmarks and face model, as a user would run it. A finer template (15,000 vertices) meets the first scan too.

Last, `mien register` without hints on three real scans and two of a person from another face model (skipped where they
are not there): distances, and where people set landmarks, how far those are from our curves (`people_landmarks.py`).
`--only real` runs these alone, `--only stage` the stage's scans without MeshMonk.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from people_landmarks import against_people, read_people

from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.faces.scan_clean import cleaned
from mien.fitting.register_scan import register_scan
from mien.io.meshes import read_scan
from mien.landmarks.lift import lift_landmarks
from mien.mesh import Mesh, loop_subdivide, submesh, vertex_normals
from mien.register import Rejection, Surface, procrustes, register_surface
from mien.stage import make_performer
from mien.stage.people.skin import SkinConfig, make_skin
from mien.stage.seeds import REPORTING_SEEDS
from mien.stage.sensors.scanner import ScanConfig
from mien.stage.sensors.scanner import scan as scan_actor

PACKAGE = "meshmonk==0.3.0"
SHARED = Path(__file__).resolve().parents[2] / "shared"
EXPRESSIONS = [{}, {"jawOpen": 0.6, "browInnerUp": 0.4}, {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.7}]
THERE = """
import sys, time
import numpy as np
import meshmonk
given = np.load(sys.argv[1])
run = getattr(meshmonk, sys.argv[3])
names = ("floating_features", "target_features", "floating_faces", "target_faces", "floating_flags", "target_flags")
begin, cpu = time.perf_counter(), time.process_time()
found = run(**{n: given[n] for n in names})
seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
np.savez(sys.argv[2], vertices=np.asarray(found.aligned_vertices, dtype=np.float64), seconds=seconds, cpu=cpu)
"""


def environment(folder: Path) -> Path | None:
    """A Python with MeshMonk in it, made in `folder`; None, and why, where that does not work."""
    uv = shutil.which("uv") or shutil.which("uv", path=str(Path(sys.executable).parent))
    python = folder / "bin" / "python"
    if uv:
        steps = [[uv, "venv", "-q", str(folder)], [uv, "pip", "install", "-q", "--python", str(python), PACKAGE]]
    else:
        steps = [[sys.executable, "-m", "venv", str(folder)], [str(python), "-m", "pip", "install", "-q", PACKAGE]]
    try:
        for step in steps:
            subprocess.run(step, check=True, capture_output=True, text=True, timeout=600)
    except (OSError, subprocess.SubprocessError) as error:
        print(f"skipped MeshMonk: {PACKAGE} could not be installed ({error})")
        return None
    return python


def meshmonk(python: Path, function: str, template: Mesh, target: Mesh) -> dict:
    """One registration there: vertices, wall and processor seconds."""
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "given.npz"), Path(folder, "found.npz")
        np.savez(
            given,
            floating_features=features(template),
            target_features=features(target),
            floating_faces=template.faces.astype(np.int32),
            target_faces=target.faces.astype(np.int32),
            floating_flags=np.ones(len(template.vertices), np.float32),
            target_flags=np.ones(len(target.vertices), np.float32),
        )
        subprocess.run([str(python), "-c", THERE, str(given), str(found), function], check=True, timeout=1200)
        with np.load(found) as data:
            return {"vertices": data["vertices"], "seconds": float(data["seconds"]), "cpu": float(data["cpu"])}


def features(mesh: Mesh) -> np.ndarray:
    """Positions and normals (n, 6), as MeshMonk takes them."""
    return np.hstack([mesh.vertices, vertex_normals(mesh.vertices, mesh.faces)]).astype(np.float32)


def ours(template: Mesh, target: Mesh) -> dict:
    """The same registration here, set-up included."""
    begin, cpu = time.perf_counter(), time.process_time()
    found = register_surface(template, target)
    return {"vertices": found.vertices, "seconds": time.perf_counter() - begin, "cpu": time.process_time() - cpu}


def row(case: str, who: str, run: dict, template: Mesh, surface: Surface, truth=None, mask=None) -> dict:
    """Figures of one run, printed: surface distance where the target goes on, and the error against the truth."""
    mask = np.ones(len(template.vertices), bool) if mask is None else mask
    pairs = surface.correspond(run["vertices"], rejection=Rejection(max_angle_deg=180.0))
    inside = pairs.accepted & mask
    figures = {
        "case": case,
        "who": who,
        "vertices": len(template.vertices),
        "wall_s": round(run["seconds"], 2),
        "cpu_s": round(run["cpu"], 2),
        "distance_mean_mm": round(float(pairs.distances[inside].mean()), 4),
        "distance_p95_mm": round(float(np.quantile(pairs.distances[inside], 0.95)), 4),
    }
    if truth is not None:
        off = np.linalg.norm(run["vertices"][: len(truth)] - truth, axis=1)[mask[: len(truth)]]
        figures["true_error_mean_mm"] = round(float(np.nanmean(off)), 3)
        figures["true_error_p95_mm"] = round(float(np.nanquantile(off, 0.95)), 3)
    values = "  ".join(f"{figures.get(name, ''):>9}" for name in COLUMNS)
    print(f"{case:<22}{who:<22}{len(template.vertices):>8}  {values}", flush=True)
    return figures


COLUMNS = ("wall_s", "cpu_s", "distance_mean_mm", "distance_p95_mm", "true_error_mean_mm", "true_error_p95_mm")
FUNCTIONS = ("nonrigid_register", "pyramid_register")


def compare(case: str, python: Path | None, template: Mesh, target: Mesh, truth=None, mask=None) -> list[dict]:
    """MeshMonk's two drivers and ours on one pair."""
    surface = Surface(target)
    runs = [(f"MeshMonk {f.split('_')[0]}", meshmonk(python, f, template, target)) for f in FUNCTIONS if python]
    runs.append(("mien, surface alone", ours(template, target)))
    return [row(case, who, run, template, surface, truth, mask) for who, run in runs]


def own_pairs(python: Path | None, folder: Path) -> list[dict]:
    """MeshMonk's template and face, at two densities."""
    if not folder.is_dir():
        print(f"skipped MeshMonk's own faces: no {folder}")
        return []
    template, target = (read_scan(folder / name).mesh for name in ("Template_10K.obj", "DemoFace_10K.obj"))
    marks = [np.loadtxt(folder / f"{name}Landmarks.csv", delimiter=",") for name in ("Template", "DemoFace")]
    placed = procrustes(*marks, scale=True).transform
    template = template.with_vertices(placed.apply(template.vertices))
    return [
        *compare("own faces, 10k", python, template, target),
        *compare("own faces, 40k", python, loop_subdivide(template)[0], loop_subdivide(target)[0]),
    ]


def staged(python: Path | None, actors: int) -> list[dict]:
    """Scans of the stage: the bundled skin placed by landmarks, and the truth of each of its vertices."""
    face, rows = load_face(), []
    skin, members = submesh(face.rig.neutral, face.skin_faces)
    mask = face.regions["face"][members] > 0.5
    for seed in REPORTING_SEEDS[:actors]:
        actor = make_skin(make_performer(seed), SkinConfig(levels=2))
        for k, expression in enumerate(EXPRESSIONS):
            weights = np.array([expression.get(name, 0.0) for name in actor.names])
            made = scan_actor(actor, weights, ScanConfig(vertices=40_000), seed=seed)
            begin, cpu = time.perf_counter(), time.process_time()
            try:
                found = register_scan(made.scan)
            except BadInput as error:
                print(f"skipped the stage: {error}")
                return rows
            whole = {"seconds": time.perf_counter() - begin, "cpu": time.process_time() - cpu}
            T = lift_landmarks(made.scan).T_face_scan
            target = cleaned(made.scan.mesh.with_vertices(T.apply(made.scan.mesh.vertices)))
            truth = T.apply(made.truth.bundled)[members]
            case = f"stage {seed}, " + ("neutral", "open", "smile")[k]
            rows += compare(case, python, skin, target, truth, mask)
            if seed == REPORTING_SEEDS[0] and not expression:
                fine, S = loop_subdivide(skin)
                rows += compare(case + ", 15k", python, fine, target, truth, np.greater(S @ mask, 0.5))
            back = T @ found.T_face_scan.inverse()
            whole = whole | {"vertices": back.apply(found.mesh.vertices)[members]}
            rows.append(row(case, "mien register, whole", whole, skin, Surface(target), truth, mask))
    return rows


REAL = {
    "james": ("data/james/james.obj", "data/james/james.ljson"),
    "Lee Perry-Smith": ("data/lee_perry_smith/LeePerrySmith.obj", None),
    "MeshMonk's raw face": ("data/meshmonk/demoFace_full.obj", None),
    "stranger, neutral": ("strangers/scans/frame_000001.ply", "strangers/truth_scans/frame_000001.npz"),
    "stranger, open mouth": ("strangers/scans/frame_000738.ply", "strangers/truth_scans/frame_000738.npz"),
}
"""Scans beside the checkout, and what says where people set their landmarks."""


def real_scans(folder: Path) -> list[dict]:
    """`mien register` without hints; printed."""
    rows = []
    for name, (path, marked) in REAL.items():
        if not (folder / path).exists():
            print(f"skipped {name}: no {folder / path}")
            continue
        scan = read_scan(folder / path)
        begin, cpu = time.perf_counter(), time.process_time()
        found = register_scan(scan)
        seconds, cpu = time.perf_counter() - begin, time.process_time() - cpu
        error = found.regions["face"]
        print(
            f"{name:<22}{len(scan.mesh.vertices):>6} vertices, {seconds:.1f} s ({cpu:.1f} of the processor): mean "
            f"{error.mean:.3f} mm, p95 {error.p95:.3f} mm over {error.covered:.0%} of the face"
        )
        figures = {"case": name, "wall_s": seconds, "cpu_s": cpu, "mean_mm": error.mean, "p95_mm": error.p95}
        off = against_people(found, read_people(folder / marked)) if marked else {}
        if off:
            print("  from people's landmarks, mm: " + ", ".join(f"{group} {mean:.2f}" for group, mean in off.items()))
        rows.append(figures | off)
    return rows


def summary(rows: list[dict]) -> None:
    """Means over the stage, one line a method."""
    print("\nmean over the stage's scans")
    for who in dict.fromkeys(r["who"] for r in rows if "true_error_mean_mm" in r):
        mine = [r for r in rows if r["who"] == who and "true_error_mean_mm" in r]
        values = "  ".join(f"{np.mean([r[name] for r in mine]):>9.3f}" for name in COLUMNS)
        print(f"{'':<22}{who:<22}{'':>8}  {values}")


def main() -> None:
    """Run every pair; print and store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--data", type=Path, default=SHARED, help="holds data/ and strangers/")
    parser.add_argument("--only", choices=["real", "stage"])
    parser.add_argument("--actors", type=int, default=2, help="of the stage (501, 502, 503); three scans each")
    given = parser.parse_args()
    rows = [] if given.only == "real" else pairs(given)
    rows += [] if given.only == "stage" else real_scans(given.data)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))


def pairs(given: argparse.Namespace) -> list[dict]:
    """Pairs of MeshMonk's and of the stage; printed."""
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start (a busy machine's times are worth less)")
    register_surface(load_face().rig.neutral, load_face().rig.neutral)  # compiled code is loaded before the clock runs
    names = ("wall s", "cpu s", "mean mm", "p95 mm", "true mean", "true p95")
    print(f"{'pair':<22}{'method':<22}{'vertices':>8}  " + "  ".join(f"{name:>9}" for name in names))
    with tempfile.TemporaryDirectory() as folder:
        python = None if given.only else environment(Path(folder))
        rows = [] if given.only else own_pairs(python, given.data / "data" / "meshmonk")
        rows += staged(python, given.actors)
    summary(rows)
    return rows


if __name__ == "__main__":
    main()
