"""Real pores at rest on a moving face: a head scan's 4096^2 displacement map on the bundled topology; draws a picture.

    python benchmarks/real_skin.py [-o real_skin.png] [--data FOLDER]

The scan is registered as `mien register` does; its map, high-passed, is the fine detail of eq. 1 with the constant term
alone (Ma et al. 2008): heights that ride on the normals of whatever the rig does. The scan is `Infinite, 3D Head Scan
by Lee Perry-Smith` (CC-BY 3.0, based on a work at www.triplegangers.com), which is not part of this repository.
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

from mien.faces.bundled import load_face
from mien.fitting.register_scan import Registration, register_scan, registered_rig
from mien.io.meshes import read_scan
from mien.mesh import Attachment, Mesh, closest_point, loop_subdivide, vertex_normals
from mien.pictures import Renderer, ambient_occlusion, frontal_camera, write_png

DATA = Path(__file__).parents[2] / "shared" / "data" / "lee_perry_smith"
SCAN, MAP = "LeePerrySmith.obj", "Infinite-Level_02_Disp_NoSmoothUV-4096.jpg"
LEVELS = 4
"""Of subdivision: vertices 0.2 mm apart, less than a pixel of the picture."""
BLUR_TEXELS = 12.0
"""Standard deviation of what is taken off the map, some 1.5 mm: what is broader the registered mesh has already."""
GREY_MM = 5.0
"""Height of the map's whole range, black to white: it states none; creases of the lips come out 0.4 mm deep."""
FARTHEST_MM = 2.0
"""Skin farther from the scan (eyeballs, the mouth's inside) has no detail."""
POSES = {
    "rest": {},
    "smile": {"mouthSmileLeft": 0.8, "mouthSmileRight": 0.8, "cheekSquintLeft": 0.6, "cheekSquintRight": 0.6},
}
PIXELS = 2000
"""Side of the whole picture, of which the lower face is kept."""
KEPT = (slice(800, 1400), slice(650, 1350))
"""Rows and columns."""


def heights_mm(scan: Mesh, found: Registration, image: np.ndarray, skin: Mesh) -> np.ndarray:
    """The map, high-passed, at the vertices of `skin` (face space), mm; 0 where the scan shows nothing."""
    assert scan.uv is not None
    placed = scan.with_vertices(found.T_face_scan.apply(scan.vertices))
    at = closest_point(placed, skin.vertices)
    points: Attachment = at.attachment()
    corners = scan.uv[(scan.faces if scan.uv_faces is None else scan.uv_faces)[points.faces]]
    uv = np.einsum("pc,pcd->pd", points.barycentric, corners)
    rows, columns = (1 - uv[:, 1]) * image.shape[0] - 0.5, uv[:, 0] * image.shape[1] - 0.5
    relief = image - ndimage.gaussian_filter(image, BLUR_TEXELS)
    out = ndimage.map_coordinates(relief, [rows, columns], order=1, mode="nearest")
    shown = at.distances < FARTHEST_MM
    return np.where(shown, GREY_MM * out, 0.0)


def main() -> None:
    """Register, displace, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("real_skin.png"))
    parser.add_argument("--data", type=Path, default=DATA)
    given = parser.parse_args()
    scan = read_scan(given.data / SCAN)
    found = register_scan(scan)
    rig = registered_rig(found, load_face())
    Image.MAX_IMAGE_PIXELS = None
    image = np.asarray(Image.open(given.data / MAP).convert("L"), np.float32) / 255
    dense, S = loop_subdivide(rig.neutral, LEVELS)
    heights = heights_mm(scan.mesh, found, image, dense)
    print(f"{len(dense.vertices):,} vertices, {np.mean(heights != 0):.0%} of them with detail; face covered "
          f"{found.regions['face'].covered:.0%}, mean {found.regions['face'].mean:.3f} mm")  # fmt: skip
    renderer, view, sky = Renderer(dense), frontal_camera(dense, PIXELS), ambient_occlusion(rig.neutral)
    rows = []
    for amount in (0.0, 1.0):
        row = []
        for pose in POSES.values():
            weights = np.array([pose.get(name, 0.0) for name in rig.names])
            moved = S @ rig.vertices(weights[None])[0]
            moved = moved + amount * heights[:, None] * vertex_normals(moved, dense.faces)
            drawn = renderer.draw(view.camera, view.T_camera_face, vertices=moved, open_sky=S @ sky)
            row.append(drawn[KEPT])
        rows.append(np.concatenate(row, axis=1))
    write_png(given.output, np.concatenate(rows))
    print(given.output)


if __name__ == "__main__":
    main()
