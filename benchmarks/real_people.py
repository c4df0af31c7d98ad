"""Photogrammetry of real people through `mien rig --arkit`: scan, rig, expressions that nobody captured; a picture.

    python benchmarks/real_people.py [-o real_people.png] [--data FOLDER]

Neither shows more than a neutral face, so all 52 shapes are the bundled ones by deformation transfer. The scans are no
part of this repository: `james` of menpo3d (BSD, Imperial College London), and `Infinite, 3D Head Scan by Lee
Perry-Smith` (CC-BY 3.0, based on a work at www.triplegangers.com).
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from mien.blendshapes.captures import Capture, read_capture
from mien.blendshapes.cylinder_map import mesh_of_map
from mien.blendshapes.pipeline import BuiltRig, build_rig
from mien.experiments.blendshapes_figures import face_look, front_of
from mien.faces.bundled import load_face
from mien.mesh import ClosestPoint, Mesh
from mien.pictures import Renderer, contact_sheet, frontal_camera, write_png
from mien.pictures.show import rig_look

DATA = Path(__file__).parents[2] / "shared" / "data"
SCANS = {
    "james": ("james/james.obj", "james/james.jpg"),
    "Lee Perry-Smith": ("lee_perry_smith/LeePerrySmith.obj", "lee_perry_smith/Map-COL.jpg"),
}
"""A mesh and its colour each."""
POSES: dict[str, dict[str, float]] = {
    "smile": {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9, "cheekSquintLeft": 0.5, "cheekSquintRight": 0.5},
    "jaw open": {"jawOpen": 0.7},
    "one eye closed": {"eyeBlinkLeft": 1.0},
    "pucker, brows up": {
        "mouthPucker": 0.9, "browInnerUp": 0.9, "browOuterUpLeft": 0.9, "browOuterUpRight": 0.9
    },
}  # fmt: skip
YAWS = (0.0, 0.7)
"""Radians: from the front and from the person's left."""
PIXELS = 280
"""Side of a cell."""


def capture_of(data: Path, name: str) -> Capture:
    """The scan with its colour beside it, as a session's folder holds them."""
    with tempfile.TemporaryDirectory() as folder:
        for file in SCANS[name]:
            (Path(folder) / Path(file).name).symlink_to((data / file).resolve())
        found = read_capture(Path(folder) / Path(SCANS[name][0]).name)
    return replace(found, map=found.map.named("neutral"))


def row(built: BuiltRig, yaw: float) -> list[np.ndarray]:
    """The scan, the rig at rest, and the poses, from one side."""
    rig = built.textured.rig
    view = frontal_camera(rig.neutral, PIXELS, yaw=yaw, frame=front_of(rig))
    scan = mesh_of_map(built.neutral.map, 2)
    look = face_look(rig)
    cells = [Renderer(scan.mesh, rig_look(scan.mesh), scan.texture).draw(*view)]
    renderer = Renderer(rig.neutral, look, rig.texture)
    for pose in ({}, *POSES.values()):
        weights = np.array([pose.get(name, 0.0) for name in rig.names])
        cells.append(renderer.draw(*view, vertices=rig.vertices(weights)))
    return cells


def told(name: str, built: BuiltRig) -> str:
    """How near the rig at rest lies to the scan's own surface."""
    artist, surface = built.neutral.artist, mesh_of_map(built.neutral.map).mesh
    face = load_face().regions["face"] > 0.5
    off = ClosestPoint(Mesh(surface.vertices, surface.faces)).query(artist.mesh.vertices[face & artist.shown]).distances
    share = (artist.shown & face).sum() / face.sum()
    return f"{name}: {share:.0%} of the face's vertices lie on the scan, {off.mean():.3f} mm off, mean"


def main() -> None:
    """Build, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("real_people.png"))
    parser.add_argument("--data", type=Path, default=DATA)
    given = parser.parse_args()
    face, cells, captions = load_face(), [], []
    for name in SCANS:
        capture = capture_of(given.data, name)
        built = build_rig([capture], "neutral", face, arkit=True)
        print(told(name, built), flush=True)
        for yaw in YAWS:
            cells += row(built, yaw)
            captions += ["scan", "rig", *POSES]
    write_png(given.output, contact_sheet(cells, captions, 2 + len(POSES)))
    print(given.output)


if __name__ == "__main__":
    main()
