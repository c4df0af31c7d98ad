"""Textured blendshapes against the truth, beside simpler ways, on two kinds of people (Casas et al. 2016).

    python benchmarks/blendshapes.py [--kind bent] [--only jawOpen,smile] [--frames 24] [--seed 1] [--json out.json]

A staged person (`bent`: bundled shapes bent; `muscles`: motion the bundled shapes do not know) holds expressions before
a structured-light sensor and turns the head. Errors are distances between each artist vertex and the place where the
truth has the same skin, mm: mean, median, 95th percentile over the face; drift is in texels of a 1024^2 texture. Every
way has its head held still by the same step. Seconds are of processor time; the paper needs about 20 s a scan with its
capture, and 60 s a blendshape with a GPU's flow.
"""

import argparse
import json
import time
from dataclasses import replace

import numpy as np

from mien.blendshapes.align import align, stabilised
from mien.blendshapes.build.artist_mesh import look_up
from mien.blendshapes.correspond.dense import WarpConfig, warp
from mien.blendshapes.correspond.landmarks import landmarks_on_map
from mien.blendshapes.correspond.model_motion import mix_of, motion_image
from mien.blendshapes.cylinder_map import mesh_of_map
from mien.blendshapes.expression import RigConfig, build_shape, neutral_face
from mien.blendshapes.scan.pipeline import scan_take
from mien.experiments.blendshapes_score import drift, true_skin
from mien.experiments.blendshapes_stage import (
    EXPRESSIONS,
    CaptureStageConfig,
    capture_actor,
    capture_weights,
    staged_capture,
)
from mien.faces import load_face
from mien.fitting.register_scan import register_scan
from mien.landmarks.detector import FaceLandmarker
from mien.mesh import ClosestPoint, mass
from mien.stage import STRANGER, PerformerConfig

SIZE = 1024
PAPER_S = {"a fused scan": 20, "a blendshape": 60}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=["bent", "muscles"], default="bent")
    parser.add_argument("--only", default=",".join(EXPRESSIONS))
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json")
    args = parser.parse_args()
    person = STRANGER if args.kind == "muscles" else PerformerConfig()
    config = CaptureStageConfig(frames=args.frames, person=person)
    actor, face, seconds = capture_actor(args.seed, config), load_face(), {name: [] for name in PAPER_S}
    landmarker = FaceLandmarker()

    def scanned(name):
        take = staged_capture(actor, name, args.seed, config).take
        frames = list(take)
        begun = time.process_time()
        map_ = scan_take(replace(take, name=name, frames=lambda: iter(frames)), landmarker=landmarker).map
        seconds["a fused scan"].append(time.process_time() - begun)
        return map_

    neutral = neutral_face(scanned("neutral"), face, RigConfig())
    truth = true_skin(actor, neutral.map, neutral.artist)
    print(f"neutral: {truth.neutral_mm:.3f} mm from the true surface, mean", flush=True)
    table = {}
    for name in args.only.split(","):
        if name != "neutral":
            map_ = scanned(name)
            begun = time.process_time()
            build_shape(map_, neutral, face, RigConfig())
            seconds["a blendshape"].append(time.process_time() - begun)
            table[name] = compare(name, map_, neutral, truth, face)
    for name, spent in seconds.items():
        print(f"{name}: {np.mean(spent):.1f} s of processor time; paper about {PAPER_S[name]} s")
    if args.json:
        with open(args.json, "w") as file:
            json.dump({"neutral_mm": truth.neutral_mm, "errors": table, "seconds": seconds}, file, indent=1)


def compare(name, map_, neutral, truth, face) -> dict[str, list[float]]:
    """Every way's errors for one expression, printed."""
    weights, rows = capture_weights(name), {}
    goal = truth.points(weights)
    share = mass(neutral.artist.mesh.vertices, neutral.artist.mesh.faces) * face.regions["face"]
    for way, found in ways(map_, neutral, face).items():
        still = stabilised(found, neutral.artist.mesh.vertices, share).apply(found)
        ok = truth.scored & np.isfinite(still[:, 0])
        off = np.linalg.norm(still - goal, axis=1)[ok]
        moved = drift(truth, still, weights, neutral.artist.mesh, SIZE)[ok]
        rows[way] = [off.mean(), np.median(off), np.quantile(off, 0.95), np.median(moved), np.quantile(moved, 0.95)]
        told = "  ".join(f"{value:6.2f}" for value in rows[way])
        print(f"{name:12} {way:24} {told}", flush=True)
    return {way: [float(v) for v in values] for way, values in rows.items()}


def ways(map_, neutral, face) -> dict[str, np.ndarray]:
    """Positions of the artist's vertices, NaN where a way gives none."""
    aligned = align(map_, landmarks_on_map(map_), neutral.map, neutral.landmarks)
    artist = neutral.artist
    pair = aligned.map, aligned.landmarks, neutral.map, neutral.landmarks
    mix = mix_of(neutral.units, artist.mesh, aligned.landmarks, neutral.landmarks)
    expected = motion_image(artist.mesh, np.tensordot(mix, neutral.units, axes=1), neutral.map.layout)
    surface = mesh_of_map(aligned.map, 2)
    nearest = ClosestPoint(surface.mesh).query(artist.mesh.vertices).points
    fitted = register_scan(surface, face)
    template = fitted.T_face_scan.inverse().apply(fitted.mesh.vertices)
    shown = artist.shown[:, None]
    return {
        "closest point": np.where(shown, nearest, np.nan),
        "template fit": np.where(shown, template, np.nan),
        "landmarks and triangles": look_up(artist, aligned.map, warp(*pair, config=WarpConfig(flow=None))),
        "... and flow (paper)": look_up(artist, aligned.map, warp(*pair)),
        "... and motion (ours)": look_up(artist, aligned.map, warp(*pair, expected=expected)),
    }


if __name__ == "__main__":
    main()
