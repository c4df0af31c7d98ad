"""Small good files of every format that mien reads, made in code, and how each is read."""

import io
import json
import struct
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from mien.camera import Camera
from mien.clip import Markers
from mien.io.gltf import read_performance, read_rig, write_performance, write_rig
from mien.io.livelink import read_live_link, write_live_link
from mien.io.markers import read_marker_file, write_c3d
from mien.io.meshes import read_scan, write_mesh
from mien.io.rigs import read_any_rig
from mien.mesh import Mesh
from mien.rgbd import read_rgbd, write_intrinsics
from mien.rig import Performance, Rig
from mien.transforms import Transform

FRAMES = 6
LABELS = tuple(f"M{i}" for i in range(8))
FACE_MM = np.array(
    [
        [60.0, 50, 10], [-60, 50, 10], [30, 55, 30], [-30, 55, 30],
        [1, 0, 60], [35, -50, 40], [-35, -50, 40], [1, -60, 50],
    ]
)  # fmt: skip
"""Eight markers as far apart as on a face."""


@dataclass(frozen=True)
class Reader:
    """A reader and files that it can read."""

    name: str
    seeds: tuple[Path, ...]
    read: Callable[[Path], object]
    kind: str = ""
    """Suffix by which mutations are chosen, where it is not the file's own."""


def readers(folder: Path) -> list[Reader]:
    """Every reader with its seed files, written under `folder`."""
    return [reader for make in (_marker_readers, _mesh_readers, _rig_readers, _take_readers) for reader in make(folder)]


def positions() -> np.ndarray:
    """(frames, markers, 3), mm, one gap."""
    moved = FACE_MM + np.random.default_rng(0).normal(0, 1, (FRAMES, len(LABELS), 3))
    moved[2, 3] = np.nan
    return moved


def surface() -> Mesh:
    """A bumpy sheet of a face's size with texture coordinates: 25 vertices, 32 triangles."""
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    vertices = np.stack([180 * u - 90, 240 * v - 120, 30 * np.sin(3 * u) * np.cos(2 * v)], axis=2).reshape(-1, 3)
    corner = (np.arange(4)[:, None] * 5 + np.arange(4)).reshape(-1)
    first = np.stack([corner, corner + 1, corner + 6], axis=1)
    second = np.stack([corner, corner + 6, corner + 5], axis=1)
    uv = np.stack([u, v], axis=2).reshape(-1, 2)
    return Mesh(vertices, np.concatenate([first, second]), uv=uv)


def rig() -> Rig:
    """The sheet with two shapes."""
    mesh = surface()
    deltas = np.stack([np.sin(mesh.vertices / 30), np.cos(mesh.vertices / 40)])
    return Rig(mesh, deltas, ("jawOpen", "browInnerUp"))


def performance() -> Performance:
    """Six frames of the rig."""
    weights = np.linspace(0, 1, 2 * FRAMES).reshape(FRAMES, 2)
    poses = Transform(np.tile(np.eye(3), (FRAMES, 1, 1)), np.zeros((FRAMES, 3)))
    return Performance(rig(), weights, poses, 30.0, np.ones(FRAMES, bool))


def fresh(folder: Path, name: str) -> Path:
    """The place of a seed in a folder of its own, so that its neighbours are its own."""
    place = folder / name
    place.parent.mkdir(parents=True, exist_ok=True)
    return place


def _marker_readers(folder: Path) -> Iterator[Reader]:
    take = Markers(positions(), LABELS, 60.0)
    c3d = fresh(folder, "c3d/take.c3d")
    write_c3d(c3d, take, up="+Z")
    integers = fresh(folder, "c3d_integers/take.c3d")
    integers.write_bytes(_c3d_in_integers())
    yield Reader("c3d", (c3d, integers), read_marker_file)
    tables = {"wide.csv": _wide(), "long.csv": _long(), "motive.csv": _motive(), "nexus.csv": _nexus()}
    tables |= {"qualisys.tsv": _qualisys(), "take.trc": _trc()}
    for name, text in tables.items():
        path = fresh(folder, f"{name.replace('.', '_')}/{name}")
        path.write_text(text)
        yield Reader(name, (path,), read_marker_file)


def _mesh_readers(folder: Path) -> Iterator[Reader]:
    mesh = surface()
    for suffix in (".ply", ".obj"):
        path = fresh(folder, f"mesh_{suffix[1:]}/scan{suffix}")
        write_mesh(path, mesh, np.full((4, 4, 3), 128, np.uint8))
        yield Reader(f"mesh{suffix}", (path,), read_scan)
    ascii_ply = fresh(folder, "mesh_text_ply/scan.ply")
    ascii_ply.write_text(_ascii_ply(mesh))
    yield Reader("mesh_text.ply", (ascii_ply,), read_scan, ".textply")
    binary_stl = fresh(folder, "mesh_stl/scan.stl")
    binary_stl.write_bytes(_stl(mesh))
    yield Reader("mesh.stl", (binary_stl,), read_scan)
    text_stl = fresh(folder, "mesh_text_stl/scan.stl")
    text_stl.write_text(_text_stl(mesh))
    yield Reader("mesh_text.stl", (text_stl,), read_scan, ".textstl")


def _rig_readers(folder: Path) -> Iterator[Reader]:
    glb = fresh(folder, "rig_glb/rig.glb")
    write_rig(glb, rig())
    yield Reader("rig.glb", (glb,), read_rig)
    yield Reader("scan.glb", (glb,), read_scan)
    played = fresh(folder, "performance_glb/perf.glb")
    write_performance(played, performance())
    yield Reader("performance.glb", (played,), read_performance)
    shapes = folder / "rig_folder"
    shapes.mkdir(parents=True)
    for name, delta in zip(("neutral", "jawOpen"), (0.0, 2.0), strict=True):
        mesh = surface()
        write_mesh(shapes / f"{name}.obj", Mesh(mesh.vertices + delta, mesh.faces, uv=mesh.uv))
    yield Reader("rig_folder", (shapes,), read_any_rig)
    live = fresh(folder, "livelink/live.csv")
    write_live_link(live, performance())
    yield Reader("livelink.csv", (live,), read_live_link)


def _take_readers(folder: Path) -> Iterator[Reader]:
    camera = Camera(20.0, 20.0, 8.0, 6.0, 16, 12)
    take = folder / "rgbd_folder"
    (take / "color").mkdir(parents=True)
    (take / "depth").mkdir()
    for i in range(3):
        Image.fromarray(np.full((12, 16, 3), 40 * i, np.uint8)).save(take / f"color/{i:06d}.png")
        Image.fromarray(np.full((12, 16), 600 + i, np.uint16)).save(take / f"depth/{i:06d}.png")
    write_intrinsics(take / "camera_intrinsic.json", camera)
    (take / "take.json").write_text(json.dumps({"depth_scale": 1000, "fps": 30}))
    (take / "timestamps.csv").write_text("frame,seconds\n" + "".join(f"{i},{i / 30:.5f}\n" for i in range(3)))
    yield Reader("rgbd_folder", (take,), lambda path: list(read_rgbd(path)))
    recording = _record3d()
    if recording is not None:
        path = fresh(folder, "record3d/take.r3d")
        path.write_bytes(recording)
        yield Reader("take.r3d", (path,), lambda path: list(read_rgbd(path)))


def _record3d() -> bytes | None:
    """A Record3D take; None where the package that packs its depth is missing."""
    try:
        import lzfse
    except ImportError:
        return None
    about = {"w": 16, "h": 12, "dw": 16, "dh": 12, "fps": 30, "K": [20, 0, 0, 0, 20, 0, 8, 6, 1]}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("metadata", json.dumps(about))
        for i in range(2):
            image = io.BytesIO()
            Image.fromarray(np.full((12, 16, 3), 90, np.uint8)).save(image, "JPEG")
            archive.writestr(f"rgbd/{i}.jpg", image.getvalue())
            archive.writestr(f"rgbd/{i}.depth", lzfse.compress(np.full((12, 16), 0.6, np.float32).tobytes()))
    return out.getvalue()


def _c3d_in_integers() -> bytes:
    """Big-endian C3D of integers with two analog channels, as older systems wrote."""
    step = 0.1
    points = np.zeros((FRAMES, len(LABELS), 4))
    points[:, :, :3] = np.nan_to_num(positions() / step)
    analog = np.ones((FRAMES, 2))
    words = np.concatenate([points.reshape(FRAMES, -1), analog], axis=1).astype(">i2")

    def record(number: int, name: str, value: bytes = b"") -> bytes:
        return struct.pack(">bb", len(name), number) + name.encode() + struct.pack(">h", len(value) + 3) + value + b"\0"

    labels = "".join(label.ljust(4) for label in LABELS).encode()
    section = struct.pack("BBBB", 1, 0x50, 1, 86) + record(-1, "POINT")
    section += record(1, "USED", struct.pack(">bBh", 2, 0, len(LABELS)))
    section += record(1, "SCALE", struct.pack(">bBf", 4, 0, step)) + record(1, "RATE", struct.pack(">bBf", 4, 0, 60.0))
    section += record(1, "LABELS", struct.pack(">bBBB", -1, 2, 4, len(LABELS)) + labels)
    section += record(1, "UNITS", struct.pack(">bBB", -1, 1, 2) + b"mm") + b"\0\0"
    header = struct.pack(">BBHHHHHfHHf", 2, 0x50, len(LABELS), 2, 1, FRAMES, 0, step, 3, 1, 60.0)
    return header.ljust(512, b"\0") + section.ljust(512, b"\0") + words.tobytes().ljust(1024, b"\0")


def _rows(scale: float = 1.0) -> list[list[str]]:
    """Positions as cells, one row a frame; "" for gaps."""
    flat = (positions() * scale).reshape(FRAMES, -1)
    return [["" if np.isnan(value) else f"{value:.6f}" for value in row] for row in flat]


def _wide() -> str:
    head = ["Frame", "Time", *(f"{label}_{axis}" for label in LABELS for axis in "xyz"), "mood"]
    body = [[str(t), f"{t / 60:.5f}", *cells, "calm"] for t, cells in enumerate(_rows())]
    return "\n".join(",".join(row) for row in [head, *body]) + "\n"


def _long() -> str:
    lines = ["frame,label,x,y,z"]
    for t, frame in enumerate(np.nan_to_num(positions())):
        lines += [f"{t},{label},{x:.3f},{y:.3f},{z:.3f}" for label, (x, y, z) in zip(LABELS, frame, strict=True)]
    return "\n".join(lines) + "\n"


def _motive() -> str:
    each = [label for label in LABELS for _ in "xyz"]
    head = [
        ["Format Version", "1.23", "Take Name", "smile", "Export Frame Rate", "60.0", "Length Units", "Meters"],
        [],
        ["", "Type", *["Rigid Body"] * 4, *["Marker"] * len(each)],
        ["", "Name", *["Head"] * 4, *(f"Jane:{label}" for label in each)],
        ["", "ID", *["AA"] * 4, *each],
        ["", "", *["Rotation"] * 4, *["Position"] * len(each)],
        ["Frame", "Time (Seconds)", *"XYZW", *("XYZ" * len(LABELS))],
    ]
    body = [[str(t), f"{t / 60:.6f}", "0", "0", "0", "1", *cells] for t, cells in enumerate(_rows(1e-3))]
    return "\n".join(",".join(row) for row in [*head, *body]) + "\n"


def _nexus() -> str:
    devices = [["Devices"], ["600"], ["", "", "Force", ""], ["Frame", "Sub Frame", "Fx", "Fy"], ["", "", "N", "N"]]
    devices += [[str(t + 1), str(s), "0.1", "0.2"] for t in range(FRAMES) for s in range(2)]
    names = ["", "", *(cell for label in LABELS for cell in (f"Jane:{label}", "", ""))]
    head = [["Trajectories"], ["60"], names, ["Frame", "Sub Frame", *("XYZ" * len(LABELS))]]
    head += [["", "", *["mm"] * 3 * len(LABELS)]]
    body = [[str(t + 1), "0", *cells] for t, cells in enumerate(_rows())]
    return "\n".join(",".join(row) for row in [*devices, [], *head, *body]) + "\n"


def _qualisys() -> str:
    head = [["NO_OF_FRAMES", str(FRAMES)], ["NO_OF_MARKERS", str(len(LABELS))], ["FREQUENCY", "60"]]
    head += [["DATA_INCLUDED", "3D"], ["MARKER_NAMES", *LABELS]]
    return "\n".join("\t".join(row) for row in [*head, *_rows()]) + "\n"


def _trc() -> str:
    head = [
        ["PathFileType", "4", "(X/Y/Z)", "take.trc"],
        ["DataRate", "CameraRate", "NumFrames", "NumMarkers", "Units"],
        ["60", "60", str(FRAMES), str(len(LABELS)), "mm"],
        ["Frame#", "Time", *(cell for label in LABELS for cell in (label, "", ""))],
        ["", "", *(f"{axis}{i + 1}" for i in range(len(LABELS)) for axis in "XYZ")],
        [],
    ]
    body = [[str(t + 1), f"{t / 60:.5f}", *cells] for t, cells in enumerate(_rows())]
    return "\n".join("\t".join(row) for row in [*head, *body]) + "\n"


def _ascii_ply(mesh: Mesh) -> str:
    head = f"ply\nformat ascii 1.0\nelement vertex {len(mesh.vertices)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    vertices = "".join(f"{x:.3f} {y:.3f} {z:.3f}\n" for x, y, z in mesh.vertices)
    return head + vertices + "".join(f"3 {a} {b} {c}\n" for a, b, c in mesh.faces)


def _stl(mesh: Mesh) -> bytes:
    record = np.zeros(
        len(mesh.faces), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    )
    record["corners"] = mesh.vertices[mesh.faces]
    return bytes(80) + struct.pack("<I", len(mesh.faces)) + record.tobytes()


def _text_stl(mesh: Mesh) -> str:
    lines = ["solid scan"]
    for corners in mesh.vertices[mesh.faces]:
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += [f"vertex {x:.3f} {y:.3f} {z:.3f}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid scan"]) + "\n"
