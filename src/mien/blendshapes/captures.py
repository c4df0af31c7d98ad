"""What a session leaves: one capture an expression, as RGB-D take, textured mesh or map; and which is the neutral."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from scipy.spatial import KDTree

from ..errors import BadInput
from ..faces.scan_clean import wound_alike
from ..files import existing
from ..io.meshes import SUFFIXES as MESHES
from ..io.meshes import read_scan
from ..io.meshes.images import read_image
from ..landmarks.detector import GROUPS
from ..landmarks.lift import lift_landmarks
from ..landmarks.stream import Landmarker
from ..mesh import Mesh, Scan
from ..mesh.scan_color import vertex_colours
from ..progress import SILENT, Progress
from ..rgbd import read_rgbd
from .cylinder_map import CylinderLayout, CylinderMap, map_of_scan
from .map_file import read_map
from .scan.pipeline import FusionConfig, scan_take

RECORDINGS = (".r3d", ".bag")
NEUTRAL_WORDS = ("neutral", "rest", "relaxed", "calm")
"""A capture with one of these words in its name is the neutral one."""
PICTURES = (".png", ".jpg", ".jpeg")
COLOUR_WORDS = {"col", "color", "colour", "diffuse", "albedo", "basecolor", "diff"}
"""Words by which a picture beside a mesh is known to be its colour."""
CHEEKS = (50, 101, 118, 280, 330, 347, 151, 9)
"""Landmarks on bare skin: cheeks and the middle of the forehead."""
MM_UNKNOWN = "unknown"


@dataclass(frozen=True)
class Capture:
    """One expression, laid out."""

    map: CylinderMap
    """In a face space of its own: as its landmarks have it."""
    summary: str
    """What it was made of, one line."""
    notes: tuple[str, ...] = ()
    """What was assumed or left out, a line each."""

    @property
    def name(self) -> str:
        """The file's or folder's stem."""
        return self.map.name


def read_capture(
    path: Path,
    depth_scale: float | None = None,
    unit: str | None = None,
    config: FusionConfig = FusionConfig(),
    progress: Progress = SILENT,
    landmarker: Landmarker | None = None,
) -> Capture:
    """One capture from a file or a folder.

    Raises:
        BadInput: it cannot be read, shows no face, or has no colour.
    """
    suffix = existing(path).suffix.lower()
    if suffix == ".exr":
        map_ = read_map(path)
        return Capture(map_, f"a map of {map_.known.sum():,} points")
    if path.is_file() and suffix in MESHES:
        scan, notes = with_picture_beside(read_scan(path, unit), path)
        capture = capture_of_mesh(scan, config.pixel_mm)
        return replace(capture, notes=notes + capture.notes)
    take = replace(read_rgbd(path, depth_scale), name=path.stem)
    found = scan_take(take, config, landmarker, progress)
    dropped = f", {found.dropped} could not be registered and were left out" if found.dropped else ""
    told = f"{found.used} frames fused{dropped}; they differ from their average by {found.deviation_mm:.2f} mm"
    return Capture(found.map, told, take.notes)


def with_picture_beside(scan: Scan, path: Path) -> tuple[Scan, tuple[str, ...]]:
    """A mesh that has texture coordinates but names no picture, with the picture that lies beside it, if one does.

    Programs disagree on which row is first: the picture is turned over where that makes brows darker, lips redder.
    """
    if scan.texture is not None or scan.mesh.uv is None:
        return scan, ()
    pictures = sorted(p for p in path.parent.iterdir() if p.suffix.lower() in PICTURES)
    own = [p for p in pictures if p.stem.lower().startswith(path.stem.lower())]
    named = [p for p in pictures if set(re.split(r"[^a-z]+", p.stem.lower())) & COLOUR_WORDS]
    chosen = next((some[0] for some in (own, named, pictures) if len(some) == 1), None)
    if chosen is None:
        return scan, ()
    note = f"{path.name}: names no texture; {chosen.name} beside it is taken"
    picture = read_image(chosen)
    points = lift_landmarks(scan).points
    ways = [replace(scan, texture=picture), replace(scan, texture=np.ascontiguousarray(picture[::-1]))]
    looks = [like_a_face(way, points) for way in ways]
    turned = looks[1] > looks[0]
    return ways[int(turned)], (note + (", turned upside down" if turned else ""),)


def like_a_face(scan: Scan, landmarks: Float[np.ndarray, "478 3"]) -> float:
    """How much darker brows and how much redder lips are than the cheeks, by a scan's own colours."""
    colours = vertex_colours(scan)
    if colours is None:
        return 0.0
    tree = KDTree(scan.mesh.vertices)

    def tone(ids: Sequence[int]) -> Float[np.ndarray, " 3"]:
        points = landmarks[list(ids)]
        points = points[np.isfinite(points[:, 0])]
        return colours[tree.query(points)[1]].mean(0) if len(points) else np.full(3, 0.5)

    cheeks, lips = tone(CHEEKS), tone(GROUPS["lips_outer"])
    brows = tone((*GROUPS["brow_left"], *GROUPS["brow_right"]))
    redness = (lips[0] - lips[1]) - (cheeks[0] - cheeks[1])
    return float(cheeks.mean() - brows.mean() + redness)


def capture_of_mesh(scan: Scan, pixel_mm: float) -> Capture:
    """A textured mesh of any unit and orientation, laid out.

    Raises:
        BadInput: it has no colour, or no face is found in it.
    """
    if scan.texture is None and scan.mesh.colors is None:
        raise BadInput(f"{scan.name}: has no texture and no vertex colours; a textured scan is needed")
    if scan.mesh.colors is None and scan.mesh.uv is None:
        raise BadInput(f"{scan.name}: has a texture but no texture coordinates (uv); export the mesh with them")
    scan = replace(scan, mesh=wound_alike(scan.mesh))
    found = lift_landmarks(scan)
    placed = in_face_space(scan.mesh, found.T_face_scan, found.inside_out)
    map_ = map_of_scan(replace(scan, mesh=placed), CylinderLayout(pixel_mm))
    unknown = found.unit == MM_UNKNOWN
    notes = (f"{scan.name}: in no known unit; brought to the average face's size",) if unknown else ()
    return Capture(map_, f"a mesh of {len(scan.mesh.vertices):,} vertices, unit {found.unit}", notes)


def in_face_space(mesh: Mesh, T_face_scan, inside_out: bool) -> Mesh:
    """The mesh moved, its triangles counter-clockwise seen from outside."""
    moved = replace(mesh, vertices=T_face_scan.apply(mesh.vertices))
    if not inside_out:
        return moved
    turned = None if moved.uv_faces is None else np.ascontiguousarray(moved.uv_faces[:, ::-1])
    return replace(moved, faces=np.ascontiguousarray(moved.faces[:, ::-1]), uv_faces=turned)


def find_captures(folder: Path) -> list[Path]:
    """The captures of a session's folder, by name: folders of takes, recordings, meshes, maps.

    Of several files of one stem (a mesh and its map) the first by `.exr`, then meshes, then recordings is taken.

    Raises:
        BadInput: no folder, or no capture in it.
    """
    if not existing(folder).is_dir():
        raise BadInput(f"{folder}: is a file; give a folder with one capture an expression")
    order = (".exr", *MESHES, *RECORDINGS)
    found: dict[str, Path] = {}
    for path in sorted(
        folder.iterdir(), key=lambda p: order.index(p.suffix.lower()) if p.suffix.lower() in order else -1
    ):
        recorded = path.is_dir() and any((path / "depth").glob("*.*"))
        if not path.name.startswith(".") and (recorded or (path.is_file() and path.suffix.lower() in order)):
            found.setdefault(path.stem, path)
    if not found:
        raise BadInput(f"{folder}: holds no capture; put one RGB-D take, textured mesh or map an expression there")
    return [found[name] for name in sorted(found)]


def neutral_of(names: Sequence[str], asked: str | None = None) -> str:
    """Which capture is the neutral one: the one asked for, else by its name, else the only one.

    Raises:
        BadInput: none, or several.
    """
    if asked is not None:
        if asked not in names:
            raise BadInput(f"--neutral {asked}: no capture is called so; there are {', '.join(names)}")
        return asked
    found = [name for name in names if any(word in name.lower() for word in NEUTRAL_WORDS)]
    if len(found) > 1:
        raise BadInput(f"{', '.join(found)}: {len(found)} neutral captures; choose one with --neutral NAME")
    if found:
        return found[0]
    if len(names) == 1:
        return names[0]
    raise BadInput(
        f"no capture is called neutral; name one so, or choose one of {', '.join(names)} with --neutral NAME"
    )
