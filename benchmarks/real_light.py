"""Active light on pictures that others took, with real cameras: a board, a face under lamps, a head under stripes.

    python benchmarks/real_light.py [board] [lamps] [stripes] [-o FOLDER] [--data FOLDER]

Leaves real_board.png, real_lamps.png and real_stripes.png. The recordings are not part of this repository:

- procam (github.com/kamino410/procam-calibration, MIT, (c) 2019 kamino410): five poses of a board of 9 x 7 corners
  under Gray codes. Camera and projector are calibrated, then each board is triangulated and held against a plane.
- near_light (github.com/yqueau/near_ps, GPL-3, Yvain Queau): a face under seven calibrated lamps near it.
  Its picture stands in a folder of its own in the docs, with that licence.
- three_phase (github.com/bluehash/3PhaseScanning, BSD, (c) 2014 kippkitts): a head under three shifted stripes. Nothing
  is calibrated: what is found is the phase, up to whole turns, and a height up to scale, sign and a projective map.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

from mien.light.calibrate import Board, calibrate_folder, find_corners, opencv
from mien.light.decode_phase import evened_phase, unwrap, wrapped_phase
from mien.light.disk.lamp_take import lamp_scan, read_lamp_take
from mien.light.disk.light_scan import LightScan
from mien.light.disk.light_take import pictures_of, read_grey
from mien.light.patterns import gray_set
from mien.light.pipeline import LightConfig, decode_capture
from mien.light.triangulate import TriangulateConfig
from mien.mesh import Mesh, grid_faces
from mien.pictures import Renderer, colors_of, contact_sheet, frontal_camera, write_png
from mien.pictures.color import to_bytes, to_srgb

DATA = Path(__file__).parents[2] / "shared" / "data"
BOARD = Board(9, 7, 75.0)
CONFIG = LightConfig(triangulate=TriangulateConfig(farthest_mm=6000.0))
"""The boards hang three to four metres away."""
TALL = 480
"""Pixels of each picture."""
FAR_MM = 5.0
"""Ends of the map of distances from a plane."""
PERIOD_PX = 25.0
"""Of the stripes on the head, about."""
FACE_SPACE = np.array([1.0, -1.0, -1.0])
"""From a camera's axes (y down, z forward) to those that pictures are drawn in."""


def board(data: Path) -> tuple[list[np.ndarray], list[str]]:
    """Calibrate, triangulate every pose, draw the last."""
    patterns = gray_set(1024, 768)
    found, notes = calibrate_folder(data / "procam", patterns, BOARD)
    errors = ", ".join(f"{name} {error:.3f}" for name, error in found.rms_px.items())
    print(f"board: px rms {errors} (the recording's author: 0.857)", *notes)
    view = found.rig.cameras[0]
    for pose in sorted((data / "procam").glob("capture_*")):
        images = np.stack([read_grey(path) for path in pictures_of(pose)])
        scan = decode_capture({view.name: images}, patterns, found.rig, CONFIG)
        full = view.straightened(images[patterns.one("full")])
        on_board = within(find_corners(pose.name, full, BOARD), full.shape)
        off = from_plane(scan.points, on_board & scan.known)
        rms = np.sqrt(np.nanmean(off**2))
        median = np.nanmedian(np.abs(off))
        shown = np.isfinite(off[on_board]).mean()
        away = np.nanmedian(scan.points[..., 2][on_board])
        print(f"  {pose.name}: {away:.0f} mm away, {rms:.2f} mm rms from a plane (median {median:.2f}) "
              f"over {shown:.0%} of the board")  # fmt: skip
    heat = to_bytes(colors_of(off, (-FAR_MM, FAR_MM), "diverging"))
    heat = np.where(np.isfinite(off)[..., None], heat, 40).astype(np.uint8)
    surface = np.where(scan.known, scan.points[..., 2], np.nan)
    pictures = [grey(full), depth_colours(surface), heat]
    return pictures, ["one of 42 pictures", "decoded: distance", f"off a plane, {-FAR_MM:.0f} to {FAR_MM:.0f} mm"]


def within(corners: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Pixels between the board's outer corners."""
    H, _ = opencv().findHomography(corners, BOARD.points[:, :2] / BOARD.square_mm)
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    u, v, w = np.tensordot(H, np.stack([x, y, np.ones_like(x)]), axes=1)
    return (u / w > 0) & (u / w < BOARD.columns - 1) & (v / w > 0) & (v / w < BOARD.rows - 1)


def from_plane(points: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Distance of each masked point from the plane that fits them best, mm; NaN elsewhere."""
    some = points[mask]
    middle = some.mean(axis=0)
    normal = np.linalg.eigh(np.cov((some - middle).T))[1][:, 0]
    return np.where(mask, (points - middle) @ normal, np.nan)


def lamps(data: Path) -> tuple[list[np.ndarray], list[str]]:
    """Normals and surface of the face under lamps."""
    take = read_lamp_take(data / "near_light")
    start = time.process_time()
    scan, words = lamp_scan(take)
    print(f"lamps: {words}; {scan.known.sum():,} pixels, {time.process_time() - start:.1f} s of processor time")
    normals = np.where(scan.known[..., None], scan.normals * FACE_SPACE, np.nan)
    pictures = [grey(take.images[3]), normal_colours(normals), drawn(scan, 0.0), drawn(scan, 0.6)]
    return pictures, ["one of 7 lamps", "normals", "integrated", "from the side"]


def drawn(scan: LightScan, yaw: float) -> np.ndarray:
    """The surface, all of one colour, as a picture."""
    made = scan.mesh()
    vertices = made.vertices * FACE_SPACE
    return clay(Mesh(vertices - vertices.mean(axis=0), made.faces), scan.albedo.shape, yaw)


def clay(mesh: Mesh, shape: tuple[int, ...], yaw: float) -> np.ndarray:
    """A mesh from the front, or round it, in the proportions of the recording's pictures."""
    size = (round(TALL * shape[1] / shape[0]), TALL)
    return Renderer(mesh).draw(*frontal_camera(mesh, size, yaw=yaw))


def stripes(data: Path) -> tuple[list[np.ndarray], list[str]]:
    """Wrapped and unwrapped phase, and the height over the plane that fits the phase best.

    Projector and camera of unknown gamma, and skin that is nearly saturated: what that leaves of waves is evened out.
    """
    images = np.stack([read_grey(data / "three_phase" / f"phase{k}.jpg") for k in (1, 2, 3)])
    phase, swing = wrapped_phase(images, 2 * np.pi / 3 * np.array([-1.0, 0.0, 1.0]))
    lit = ndimage.binary_opening(swing > 0.08, iterations=2)
    labels, _ = ndimage.label(lit)
    mask = labels == np.argmax(np.bincount(labels.ravel())[1:]) + 1
    whole = unwrap(np.where(mask, evened_phase(phase, mask, PERIOD_PX), phase), mask)
    y, x = np.nonzero(mask)
    design = np.stack([x, y, np.ones_like(x)], 1).astype(float)
    slope = np.linalg.lstsq(design, whole[mask], rcond=None)[0]
    bulge = np.full(mask.shape, np.nan)
    bulge[mask] = whole[mask] - design @ slope
    turns = np.ptp(whole[mask]) / (2 * np.pi)
    steps = np.concatenate([np.diff(whole, axis=axis).ravel() for axis in (0, 1)])
    torn = np.mean(np.abs(steps[np.isfinite(steps)]) > np.pi)
    print(f"stripes: {mask.sum():,} pixels in one piece, {turns:.1f} periods, {torn:.2%} of neighbours a turn apart")
    pictures = [grey(images[0]), ramp(np.where(mask, phase, np.nan)), ramp(whole), relief(bulge)]
    return pictures, ["one of 3 pictures", "wrapped phase", "unwrapped", "height, no scale"]


def relief(bulge: np.ndarray, pixels_a_radian: float = 9.0) -> np.ndarray:
    """A height field as a picture; its scale and its sign are chosen, they are not known."""
    y, x = np.mgrid[: bulge.shape[0], : bulge.shape[1]].astype(float)
    smooth = ndimage.median_filter(bulge, 3)
    points = np.stack([x, -y, pixels_a_radian * smooth], -1)
    known = np.isfinite(points).all(-1)
    number = np.cumsum(known) - 1
    faces = number[grid_faces(points, 12.0)]
    return clay(Mesh(points[known], faces), bulge.shape, 0.4)


def grey(linear: np.ndarray) -> np.ndarray:
    """A linear picture as it looks."""
    bright = max(float(np.quantile(linear, 0.995)), 1e-6)
    return np.repeat(to_bytes(to_srgb(np.clip(linear / bright, 0, 1)))[..., None], 3, axis=-1)


def ramp(values: np.ndarray) -> np.ndarray:
    """A phase as grey, black to white over its range; dark red where unknown."""
    known = np.isfinite(values)
    low, high = np.nanmin(values), np.nanmax(values)
    shade = np.nan_to_num((values - low) / (high - low))
    return np.where(known[..., None], to_bytes(shade)[..., None], np.array([60, 20, 20])).astype(np.uint8)


def depth_colours(z: np.ndarray) -> np.ndarray:
    """Distances between their 2nd and 98th percentile."""
    near, far = np.nanquantile(z, [0.02, 0.98])
    colours = to_bytes(colors_of(z, (near, far)))
    return np.where(np.isfinite(z)[..., None], colours, 40).astype(np.uint8)


def normal_colours(normals: np.ndarray) -> np.ndarray:
    """x, y, z as red, green, blue."""
    return np.where(np.isfinite(normals), to_bytes(np.nan_to_num(normals) / 2 + 0.5), 40).astype(np.uint8)


def sheet(pictures: list[np.ndarray], captions: list[str]) -> np.ndarray:
    """Side by side, all as tall as one another."""
    shape = pictures[0].shape
    size = (round(TALL * shape[1] / shape[0]), TALL)
    small = [np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS)) for picture in pictures]
    return contact_sheet(small, captions, columns=len(small))


PARTS: dict[str, Callable[[Path], tuple[list[np.ndarray], list[str]]]] = {
    "board": board,
    "lamps": lamps,
    "stripes": stripes,
}


def main() -> None:
    """Draw each part that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help=f"{', '.join(PARTS)}; all where none is named")
    parser.add_argument("-o", "--output", type=Path, default=Path("."))
    parser.add_argument("--data", type=Path, default=DATA)
    given = parser.parse_args()
    for name in given.parts or PARTS:
        path = given.output / f"real_{name}.png"
        write_png(path, sheet(*PARTS[name](given.data)))
        print(path)


if __name__ == "__main__":
    main()
