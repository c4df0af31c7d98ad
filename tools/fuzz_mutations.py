"""Ways to damage a file: its bytes, its lines and cells, its JSON, the members of its archive or folder."""

import io
import json
import random
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

Mutation = Callable[[random.Random, bytes], bytes]

EXTREMES = (
    "", "x", "0", "-1", "1e999", "-1e308", "nan", "NaN", "inf", "65535", "2147483648", "99999999999999999999999",
    "1,5", "1.2.3", "0x10", "1_0", "\x00", "é", '"', "'", "[]", "{}", "null", "true", "../x", "%s",
)  # fmt: skip
"""Cells and numbers that a reader may not expect."""

VALUES = (
    None,
    True,
    -1,
    0,
    1,
    255,
    10**6,
    2**31,
    2**63,
    10**30,
    0.5,
    1e300,
    float("nan"),
    "x",
    "",
    [],
    {},
    [0],
    "0",
    [[]],
)
"""JSON values that a reader may not expect."""

_WORDS = (0, 1, 2, 255, 32767, 32768, 65535)
_LONG_WORDS = (0, 1, 2**16, 2**31 - 1, 2**31, 2**32 - 1)
_GLB_HEAD = 20


def damaged(rng: random.Random, data: bytes, suffix: str) -> bytes:
    """The bytes after one to four mutations that suit files of this suffix."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = rng.choice(_suiting(suffix))(rng, data)
    return data


def damaged_folder(rng: random.Random, folder: Path) -> None:
    """One file of a folder damaged, emptied, removed, doubled or renamed."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    path = rng.choice(paths)
    what = rng.choice(("damage", "damage", "damage", "empty", "remove", "copy", "rename"))
    if what == "damage":
        path.write_bytes(damaged(rng, path.read_bytes(), path.suffix.lower()))
    elif what == "empty":
        path.write_bytes(b"")
    elif what == "remove":
        path.unlink()
    elif what == "copy":
        path.with_name(f"{path.stem}_2{path.suffix}").write_bytes(path.read_bytes())
    else:
        path.rename(path.with_name(f"x{path.name}"))


def _suiting(suffix: str) -> tuple[Mutation, ...]:
    if suffix in (".csv", ".tsv", ".trc", ".txt", ".obj", ".mtl", ".textply", ".textstl"):
        return (change_bytes, change_line, change_line, change_cell, change_cell, change_cell, re_encode)
    if suffix == ".json":
        return (change_bytes, change_json, change_json, change_json)
    if suffix == ".glb":
        return (change_bytes, change_glb, change_glb, change_glb, change_words)
    if suffix in (".r3d", ".npz", ".zip"):
        return (change_bytes, change_archive, change_archive, change_archive)
    return (change_bytes, change_bytes, change_words)


def change_bytes(rng: random.Random, data: bytes) -> bytes:
    """Some bytes flipped, filled, cut out, put in, doubled, or the end cut off."""
    if not data:
        return bytes(rng.randrange(256) for _ in range(rng.randrange(9)))
    what = rng.choice(("flip", "flip", "fill", "cut", "insert", "double", "end"))
    at = rng.randrange(len(data))
    size = min(len(data) - at, rng.choice((1, 2, 4, 16, 200)))
    if what == "flip":
        out = bytearray(data)
        for _ in range(rng.choice((1, 2, 8))):
            out[rng.randrange(len(out))] = rng.randrange(256)
        return bytes(out)
    if what == "end":
        return data[:at]
    middle = {"fill": bytes([rng.choice((0, 255))]) * size, "cut": b"", "double": 2 * data[at : at + size]}
    new = middle.get(what, bytes(rng.randrange(256) for _ in range(size)))
    return data[:at] + new + data[at + (0 if what == "insert" else size) :]


def change_words(rng: random.Random, data: bytes) -> bytes:
    """A 16- or 32-bit number, most often near the start, replaced by an extreme one."""
    if len(data) < 8:
        return data
    at = rng.randrange(min(len(data) - 4, rng.choice((64, 1024, len(data)))))
    new = struct.pack(rng.choice("<>") + "H", rng.choice(_WORDS))
    if rng.random() < 0.5:
        new = struct.pack(rng.choice("<>") + "I", rng.choice(_LONG_WORDS))
    return data[:at] + new + data[at + len(new) :]


def change_line(rng: random.Random, data: bytes) -> bytes:
    """A line removed, doubled, emptied, swapped with another, or a section cut out."""
    lines = data.split(b"\n")
    a, b = (rng.randrange(min(len(lines), rng.choice((8, 10**9)))) for _ in range(2))
    what = rng.choice(("remove", "double", "empty", "swap", "section", "first"))
    if what == "swap":
        lines[a], lines[b] = lines[b], lines[a]
    elif what == "section":
        del lines[min(a, b) : max(a, b)]
    else:
        lines[a : a + 1] = {"remove": [], "double": [lines[a]] * 2, "empty": [b""], "first": lines[a : a + 1]}[what]
    if what == "first":
        lines = lines[a:]
    return b"\n".join(lines)


def change_cell(rng: random.Random, data: bytes) -> bytes:
    """A cell of one line replaced, removed, doubled or swapped with its neighbour."""
    lines = data.split(b"\n")
    a = rng.randrange(min(len(lines), rng.choice((8, 10**9))))
    mark = max((b"\t", b";", b",", b" "), key=lines[a].count)
    cells = lines[a].split(mark)
    i = rng.randrange(len(cells))
    what = rng.choice(("replace", "replace", "replace", "remove", "double", "swap"))
    if what == "replace":
        cells[i] = rng.choice(EXTREMES).encode()
    elif what == "swap":
        j = rng.randrange(len(cells))
        cells[i], cells[j] = cells[j], cells[i]
    else:
        cells[i : i + 1] = [] if what == "remove" else [cells[i]] * 2
    lines[a] = mark.join(cells)
    return b"\n".join(lines)


def re_encode(rng: random.Random, data: bytes) -> bytes:
    """The text in another encoding, with other line ends, or with another delimiter."""
    text = data.decode("latin-1")
    ways = (
        lambda: text.encode("utf-16"),
        lambda: b"\xef\xbb\xbf" + data,
        lambda: text.replace("\n", "\r\n").encode("latin-1"),
        lambda: text.replace("\n", "\r").encode("latin-1"),
        lambda: text.replace(",", ";").encode("latin-1"),
        lambda: text.replace("\t", " ").encode("latin-1"),
        lambda: text.replace(".", ",").encode("latin-1"),
    )
    return rng.choice(ways)()


def change_json(rng: random.Random, data: bytes) -> bytes:
    """A value somewhere in the JSON replaced, or an entry removed."""
    try:
        content = json.loads(data)
    except ValueError:
        return change_bytes(rng, data)
    return json.dumps(_changed(rng, content)).encode()


def change_glb(rng: random.Random, data: bytes) -> bytes:
    """A value in the JSON chunk of a GLB changed, lengths mended."""
    if len(data) < _GLB_HEAD:
        return change_bytes(rng, data)
    length = struct.unpack_from("<I", data, 12)[0]
    chunk = change_json(rng, data[_GLB_HEAD : _GLB_HEAD + length])
    chunk += b" " * (-len(chunk) % 4)
    rest = data[_GLB_HEAD + length :]
    head = data[:8] + struct.pack("<II", _GLB_HEAD + len(chunk) + len(rest), len(chunk)) + data[16:20]
    return head + chunk + rest


def change_archive(rng: random.Random, data: bytes) -> bytes:
    """A member of a zip archive damaged or left out."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError, RuntimeError, EOFError):
        return change_bytes(rng, data)
    if not members:
        return change_bytes(rng, data)
    name = rng.choice(sorted(members))
    body = members.pop(name)
    if rng.random() < 0.8:
        change = change_json if body[:1] == b"{" else rng.choice((change_bytes, change_words))
        members[name] = change(rng, body)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    return out.getvalue()


def _changed(rng: random.Random, node):
    """A copy of a JSON value with one place changed."""
    if isinstance(node, dict) and node and rng.random() < 0.9:
        key = rng.choice(sorted(node))
        if rng.random() < 0.2:
            return {other: value for other, value in node.items() if other != key}
        return {**node, key: _changed(rng, node[key])}
    if isinstance(node, list) and node and rng.random() < 0.9:
        i = rng.randrange(len(node))
        if rng.random() < 0.2:
            return node[:i] + node[i + 1 :]
        return [*node[:i], _changed(rng, node[i]), *node[i + 1 :]]
    return rng.choice(VALUES)
