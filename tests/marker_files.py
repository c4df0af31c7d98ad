"""Marker takes in code and their files, for the tests of the readers."""

import struct
from pathlib import Path

import ezc3d
import numpy as np
import pytest

from mien.clip import Markers
from mien.errors import BadInput
from mien.io.markers import read_markers

# Eight points of a face's size (box diagonal 170 mm), none at zero.
FACE = np.array(
    [
        [60.0, 50, 10], [-60, 50, 10], [30, 55, 30], [-30, 55, 30],
        [1, 0, 60], [35, -50, 40], [-35, -50, 40], [1, -60, 50],
    ]
)  # fmt: skip
NAMES = tuple(f"M{i}" for i in range(8))


def take(frames: int = 5, rate: float = 60.0) -> Markers:
    rng = np.random.default_rng(7)
    positions = FACE + rng.normal(0, 1, (frames, 8, 3))
    positions[1, 2] = np.nan
    return Markers(positions, NAMES, rate)


def wide_csv(path: Path, positions: np.ndarray, header=lambda n, a: f"{n}_{a}", sep: str = ",", extra=()) -> Path:
    columns = [header(n, a) for n in NAMES[: positions.shape[1]] for a in "xyz"]
    rows = [sep.join([*(c for c, _ in extra), *columns])]
    for t, frame in enumerate(positions.reshape(len(positions), -1)):
        cells = ["NA" if np.isnan(v) else f"{v:.6f}" for v in frame]
        if sep == ";":
            cells = [c.replace(".", ",") for c in cells]
        rows.append(sep.join([*(str(values[t]) for _, values in extra), *cells]))
    path.write_text("\n".join(rows) + "\n")
    return path


def refusal(path: Path, **options) -> str:
    with pytest.raises(BadInput) as caught:
        read_markers(path, **options)
    line = str(caught.value)
    assert "\n" not in line
    return line


def custom_c3d(path: Path, labels: list[str], points: np.ndarray, units=("mm",), groups: dict | None = None) -> Path:
    """A C3D as a capture program might write it: points (t, k, 3)."""
    content = ezc3d.c3d()
    point = content["parameters"]["POINT"]
    point["RATE"]["value"] = [100.0]
    point["LABELS"]["value"] = labels
    point["UNITS"]["value"] = list(units)
    for name, values in (groups or {}).items():
        content.add_parameter("POINT", name, values)
    data = np.ones((4, len(labels), len(points)))
    data[:3] = points.transpose(2, 1, 0)
    content["data"]["points"] = data
    content.write(str(path))
    return path


def trc(path: Path, positions: np.ndarray, units: str = "mm") -> Path:
    names = "\t\t\t".join(NAMES)
    axes = "\t".join(f"{a}{i + 1}" for i in range(8) for a in "XYZ")
    lines = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"100\t100\t{len(positions)}\t8\t{units}\t100\t1\t{len(positions)}",
        f"Frame#\tTime\t{names}\t\t",
        f"\t\t{axes}",
        "",
    ]
    for t, frame in enumerate(positions.reshape(len(positions), -1)):
        lines.append("\t".join([str(t + 1), f"{t / 100:.3f}", *("" if np.isnan(v) else f"{v:.6f}" for v in frame)]))
    path.write_text("\n".join(lines))
    return path


def cells(positions: np.ndarray, decimals: int = 6) -> list[list[str]]:
    """One row a frame, three cells a marker, "" for gaps."""
    rows = positions.reshape(len(positions), -1)
    return [["" if np.isnan(value) else f"{value:.{decimals}f}" for value in row] for row in rows]


def record(number: int, name: str, value: bytes = b"", end: str = "<") -> bytes:
    """A group (negative number) or parameter of a C3D file, with an empty description."""
    head = struct.pack("bb", len(name), number) + name.encode()
    return head + struct.pack(end + "h", len(value) + 3) + value + b"\0"


def c3d_bytes(
    positions: np.ndarray,
    labels: tuple[str, ...] = NAMES,
    scale: float = -1.0,
    processor: int = 84,
    analog: int = 0,
    extra: bytes = b"",
    extra_first: bool = False,
) -> bytes:
    """A C3D file by hand: positions (t, k, 3) with NaN for gaps, floats (scale < 0) or integers, any processor.

    `extra` are more records behind (or ahead of) POINT's.
    """
    end = ">" if processor == 86 else "<"
    frames, points = positions.shape[:2]

    def real(value: float) -> bytes:
        return vax(value) if processor == 85 else struct.pack(end + "f", value)

    def section(data_block: int) -> bytes:
        text = "".join(label.ljust(4) for label in labels).encode()
        own = record(-1, "POINT", end=end) + record(1, "USED", struct.pack(end + "bBH", 2, 0, points), end)
        own += record(1, "RATE", b"\4\0" + real(60.0), end) + record(1, "SCALE", b"\4\0" + real(scale), end)
        own += record(1, "LABELS", struct.pack("bBBB", -1, 2, 4, len(labels)) + text, end)
        own += record(1, "UNITS", struct.pack("bBB", -1, 1, 2) + b"mm", end)
        own += record(1, "DATA_START", struct.pack(end + "bBH", 2, 0, data_block), end)
        own += record(-2, "ANALOG", end=end) + record(2, "USED", struct.pack(end + "bBH", 2, 0, analog), end)
        own += record(2, "RATE", b"\4\0" + real(60.0), end)
        own += record(2, "GEN_SCALE", b"\4\0" + real(1.0), end)
        own += record(2, "SCALE", struct.pack("bBB", 4, 1, analog) + real(1.0) * analog, end)
        own += record(2, "OFFSET", struct.pack(end + f"bBB{analog}h", 2, 1, analog, *[0] * analog), end)
        own += record(2, "LABELS", struct.pack("bBBB", -1, 2, 1, analog) + b"a" * analog, end)
        own += record(-3, "FORCE_PLATFORM", end=end) + record(3, "USED", struct.pack(end + "bBH", 2, 0, 0), end)
        both = extra + own if extra_first else own + extra
        body = b"\0\0\0" + bytes([processor]) + both + b"\0\0"
        body += bytes(-len(body) % 512)
        return b"\1\x50" + bytes([len(body) // 512]) + body[3:]

    data_block = 2 + len(section(0)) // 512
    head = struct.pack("BB", 2, 0x50) + struct.pack(end + "HHHHH", points, analog, 1, frames % 65536, 0)
    head += real(scale) + struct.pack(end + "HH", data_block, 1 if analog else 0) + real(60.0)
    values = np.zeros((frames, 4 * points + analog))
    four = values[:, : 4 * points].reshape(frames, points, 4)
    four[:, :, :3] = np.nan_to_num(positions) / (1.0 if scale < 0 else scale)
    four[:, :, 3] = np.where(np.isnan(positions[:, :, 0]), -1.0, 0.0)
    values[:, : 4 * points] = four.reshape(frames, -1)
    if scale > 0:
        stored = np.round(values).astype(end + "i2").tobytes()
    elif processor == 85:
        stored = b"".join(vax(value) for value in values.ravel())
    else:
        stored = values.astype(end + "f4").tobytes()
    return head.ljust(512, b"\0") + section(data_block) + stored + bytes(-len(stored) % 512)


def vax(value: float) -> bytes:
    """A VAX F float: IEEE times four, its halves swapped."""
    raw = struct.pack("<f", 4 * value)
    return raw[2:] + raw[:2]
