"""Tracking speed, stage by stage, beside Li et al. 2013 (a 4-core laptop of 2012).

    python benchmarks/tracking.py [--frames 120] [--json out.json]

The mesh is the bundled face cut anew to the paper's size (about 6,900 vertices, 3,480 in front), the images are
640 x 480 with 0.8 mm of noise at 0.7 m and a mottled skin for the photometric term; landmarks are told, since they come
from another thread.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small products: waking a second thread costs more than it gives

import argparse
import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import igl
import numpy as np

from mien.camera import Camera
from mien.depth import RGBDFrame
from mien.faces.bundled import load_face
from mien.landmarks.detector import Landmarks2D
from mien.landmarks.on_rig import LandmarkMap, attach_landmarks, bundled_map, feature_points
from mien.mesh import Mesh, loop_subdivide
from mien.pictures.raycast import DepthImage, depth_image
from mien.rig import Rig
from mien.tracking.model import tracking_model
from mien.tracking.tracker import step
from mien.tracking.tracker_context import initial_state, tracker_context
from mien.transforms import Transform, rotation_from_vector

CAMERA = Camera(525.0, 525.0, 319.5, 239.5, 640, 480)
FINER = 0.75
"""How much larger the face is made for the cutting, so that about 3,480 vertices lie in front."""
PAPER = {
    "crop and smooth": None,
    "rigid motion": 3.2,
    "initial blendshapes": 3.0,
    "adaptive space": 9.0,
    "output deformation": 4.2,
    "incremental PCA": 3.0,
    "standing errors": None,
    "appearance": None,
    "skin motion": None,
    "weights anew": None,
}


class Laps:
    """Milliseconds a stage, by the clock and of this thread's own work."""

    def __init__(self):
        self.stages: dict[str, list[tuple[float, float]]] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        wall, own = time.perf_counter(), time.thread_time()
        yield
        spent = 1000 * (time.perf_counter() - wall), 1000 * (time.thread_time() - own)
        self.stages.setdefault(name, []).append(spent)


def paper_sized(count: int = 6918) -> tuple[Rig, LandmarkMap]:
    """The bundled rig, cut finer by Loop's rules, then to `count` vertices, more of them in the face."""
    face = load_face()
    fine, S = loop_subdivide(face.rig.neutral)
    magnified = fine.vertices * (1 + FINER * (S @ face.regions["face"])[:, None])
    _, faces, _, kept = igl.decimate(magnified, fine.faces.astype(np.int64), round(1.962 * count))
    kept = np.asarray(kept).ravel()
    mesh = Mesh(fine.vertices[kept], np.asarray(faces))
    rig = Rig(mesh, np.stack([(S @ shape)[kept] for shape in face.rig.deltas]), face.rig.names)
    known = bundled_map()
    return rig, attach_landmarks(mesh, feature_points(known, face.rig.neutral), known.known)


def stage(rig: Rig, landmarks: LandmarkMap, frames: int):
    """Frames and landmarks of a face that talks, smiles and bulges in ways its rig does not know."""
    rng = np.random.default_rng(0)
    spot = landmarks.attachment.points(rig.neutral)[425]
    albedo = rng.uniform(120, 160, len(rig.neutral.vertices))
    near = np.exp(-(((rig.neutral.vertices - spot) ** 2).sum(1)) / 20**2)[:, None]
    for t in range(frames):
        weights = np.zeros(len(rig.names))
        weights[rig.index("jawOpen")] = 0.4 * np.sin(t / 12) ** 2
        weights[rig.index("mouthSmileLeft")] = 0.6 * np.sin(t / 17) ** 2
        mesh = rig.mesh(weights)
        mesh = mesh.with_vertices(mesh.vertices + near * [3, 0, 5] * np.sin(t / 9) ** 2)
        turn = rotation_from_vector(np.array([0.1 * np.sin(t / 20), 0.2 * np.sin(t / 25), 0.0]))
        T = Transform(np.diag([1.0, -1.0, -1.0]) @ turn, np.array([10 * np.sin(t / 15), 0.0, 700.0]))
        seen = depth_image(mesh, CAMERA, T)
        depth = seen.depth
        depth = np.nan_to_num(depth + rng.normal(0, 0.8, depth.shape)).astype(np.float32)
        points = CAMERA.project(T.apply(landmarks.attachment.points(mesh))) + rng.normal(0, 0.3, (478, 2))
        yield RGBDFrame(coloured(seen, mesh, albedo), depth, t / 30), Landmarks2D(points, np.zeros(478), {})


def coloured(seen: DepthImage, mesh: Mesh, albedo: np.ndarray) -> np.ndarray:
    """The picture (h, w, 3) of a skin with a grey level a vertex."""
    there = seen.faces >= 0
    grey = np.zeros(seen.faces.shape)
    grey[there] = (albedo[mesh.faces[seen.faces[there]]] * seen.barycentric[there]).sum(1)
    return np.repeat(grey.astype(np.uint8)[:, :, None], 3, axis=2)


def measure(frames: int) -> dict:
    """Medians and 99th percentiles, ms; the first 20 frames compile and settle."""
    rig, landmarks = paper_sized()
    model = tracking_model(rig, landmarks)
    laps, whole = Laps(), []
    context = tracker_context(model, CAMERA, timer=laps)
    state = initial_state(context)
    for frame, marks in list(stage(rig, landmarks, frames)):
        wall, own = time.perf_counter(), time.thread_time()
        state, _ = step(context, frame, marks, state)
        whole.append((1000 * (time.perf_counter() - wall), 1000 * (time.thread_time() - own)))
    stages = {name: np.median(np.array(values[20:]), axis=0).tolist() for name, values in laps.stages.items()}
    return {
        "vertices": len(model.rig.neutral.vertices),
        "front": len(model.front),
        "shapes": model.shapes,
        "stages_ms": stages,
        "pca_p99_ms": np.percentile(np.array(laps.stages["incremental PCA"][20:]), 99, axis=0).tolist(),
        "frame_median_ms": np.median(np.array(whole[20:]), axis=0).tolist(),
        "frame_p99_ms": np.percentile(np.array(whole[20:]), 99, axis=0).tolist(),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    found = measure(arguments.frames)
    print(f"{found['vertices']} vertices, {found['front']} in front, {found['shapes']} shapes")
    print(f"{'stage':24}{'paper ms':>10}{'ours ms':>10}{'cpu ms':>10}{'ratio':>8}")
    for name, (wall, cpu) in found["stages_ms"].items():
        paper = PAPER[name]
        print(f"{name:24}{paper or '':>10}{wall:10.2f}{cpu:10.2f}" + (f"{paper / wall:8.1f}" if paper else ""))
    wall, cpu = found["frame_median_ms"]
    print(f"{'whole frame, median':24}{22.4:10.1f}{wall:10.2f}{cpu:10.2f}{22.4 / wall:8.1f}")
    print(f"{'whole frame, p99':24}{'':10}{found['frame_p99_ms'][0]:10.2f}{found['frame_p99_ms'][1]:10.2f}")
    print(f"{'PCA update, p99':24}{'':10}{found['pca_p99_ms'][0]:10.2f}{found['pca_p99_ms'][1]:10.2f}")
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    if arguments.json:
        arguments.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
