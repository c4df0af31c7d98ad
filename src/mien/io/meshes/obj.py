"""Wavefront OBJ: vertex order kept exactly, texture coordinates by corner, vertex colours, the material's picture."""

import re
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from ...errors import BadInput
from ...files import existing, whole
from ...mesh import Mesh
from ...text.decode_text import decode_bytes, is_wide_text
from ...text.parse_numbers import SPACE, parse_floats, parse_integers, token_starts, tokens_by_line
from .images import write_image
from .materials import pictures_of
from .polygons import fan
from .texture_pages import Pages, mesh_on_pages

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Which some editors put ahead of UTF-8 text."""
_COMMENT = re.compile(rb"(?<![^\s])#[^\n]*")
_NO_NUMBER = re.compile(rb"-?\d\.#[A-Za-z]+\d*")
"""How some C libraries print what is no number: `1.#QNAN`, `-1.#IND`."""

_APART = re.compile(rb"[ \t]*(?:-?\d*\.[ \t]+\d+(?:[ \t\r]+|(?=\n))){2,}\n")
"""A line of numbers whose decimals do not hang together: `10. 25 0. 5 3. 0`."""
_FULL = 255.0
"""The brightest colour of those who count in whole numbers."""


def read_obj(path: str | Path) -> tuple[Mesh, Path | Pages | None]:
    """The mesh of an OBJ file in the file's unit, and where its colour picture is, or its several pages are.

    Polygons become fans of triangles; groups and materials are one mesh; normals, lines and points are left out. Vertex
    colours are read from `v x y z r g b`. The picture is the `map_Kd` of the first material used, else an image of the
    same name beside the file; None where there is none. Where materials have several pictures, texture coordinates are
    those of all of them above each other (see `texture_pages`); so too where some have one and others none.

    Raises:
        BadInput: missing, binary, a line that is no number, an index of a vertex that is not there.
    """
    path = existing(path)
    text = _Text(path, _plain(path))
    points = _table(text, b"v", fewest=3)
    texels = _table(text, b"vt", fewest=2)
    corners, counts = _corners(text)
    triangles = fan(counts)
    faces = _indices(text, corners[:, 0], counts, b"v", len(points))[triangles]
    uv, uv_faces = None, None
    if len(texels) and (corners[:, 1] != 0).any():
        uv, uv_faces = _texture_corners(text, texels[:, :2], corners[:, 1], counts, triangles)
        if len(uv) == len(points) and np.array_equal(uv_faces, faces):
            uv_faces = None
    colors = _colors(text, points[:, 3:6]) if points.shape[1] >= 6 else None
    mesh = Mesh(points[:, :3], faces, uv, uv_faces, colors)
    if uv is None:
        return mesh, None
    pages, of_polygon = _pages(text)
    if len(pages) < 2:
        return mesh, _picture(text)
    of_triangle = np.repeat(of_polygon, np.maximum(counts - 2, 0))
    return mesh_on_pages(mesh, of_triangle, pages), pages


def write_obj(path: str | Path, mesh: Mesh, texture: UInt8[np.ndarray, "h w 3"] | None = None) -> None:
    """Write a mesh as OBJ in its own unit (millimetres), six decimals; with `texture` also STEM.mtl and STEM.png.

    Raises:
        BadInput: the folder does not exist.
    """
    path = Path(path)
    head = ""
    if texture is not None and mesh.uv is not None:
        write_image(path.with_suffix(".png"), texture)
        with whole(path.with_suffix(".mtl")) as temporary:
            temporary.write_text(f"newmtl skin\nKd 1 1 1\nmap_Kd {path.stem}.png\n")
        head = f"mtllib {path.stem}.mtl\nusemtl skin\n"
    columns = mesh.vertices if mesh.colors is None else np.concatenate([mesh.vertices, mesh.colors], axis=1)
    text = [head, _lines("v" + " %.6f" * columns.shape[1], columns)]
    if mesh.uv is None:
        text.append(_lines("f %d %d %d", mesh.faces + 1))
    else:
        uv_faces = mesh.faces if mesh.uv_faces is None else mesh.uv_faces
        text.append(_lines("vt %.8f %.8f", mesh.uv))
        text.append(_lines("f %d/%d %d/%d %d/%d", np.stack([mesh.faces, uv_faces], axis=2).reshape(-1, 6) + 1))
    with whole(path) as temporary:
        temporary.write_text("".join(text))


def _lines(pattern: str, rows: np.ndarray) -> str:
    return ((pattern + "\n") * len(rows)) % tuple(rows.ravel().tolist())


class _Text:
    """An OBJ file as bytes, and which line begins with which word."""

    def __init__(self, path: Path, data: bytes):
        self.path, self.data = path, data
        raw = np.frombuffer(data + b"\n   ", np.uint8)
        stops = np.flatnonzero(raw == ord("\n"))
        self.starts, self.stops = np.concatenate([[0], stops[:-1] + 1]), stops
        self._raw = raw

    def is_kind(self, kind: bytes) -> Bool[np.ndarray, " lines"]:
        """Lines whose first word is `kind`."""
        found = np.ones(len(self.starts), dtype=bool)
        for i, letter in enumerate(kind):
            found &= self._raw[np.minimum(self.starts + i, len(self._raw) - 1)] == letter
        after = self._raw[np.minimum(self.starts + len(kind), len(self._raw) - 1)]
        return found & ((after == ord(" ")) | (after == ord("\t")))

    def lines(self, kind: bytes) -> bytes:
        """The lines of that kind, without their first word."""
        at = np.flatnonzero(self.is_kind(kind))
        if len(at) == 0:
            return b""
        cuts = np.flatnonzero(np.diff(at) > 1)
        first, last = at[np.concatenate([[0], cuts + 1])], at[np.concatenate([cuts, [len(at) - 1]])]
        runs = zip(self.starts[first].tolist(), self.stops[last].tolist(), strict=True)
        joined = b"\n" + b"\n".join([self.data[a:b] for a, b in runs])
        return joined.replace(b"\n" + kind, b"\n")[1:]


def _plain(path: Path) -> bytes:
    """The file without line continuations and blanks ahead of a line's first word; lines end in a line feed."""
    data = path.read_bytes().removeprefix(BYTE_ORDER_MARK)
    if is_wide_text(data):
        data = decode_bytes(path, data).encode()
    if b"\r" in data and b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    if b"\n " in data or b"\n\t" in data or data[:1] in (b" ", b"\t"):
        data = re.sub(rb"(?m)^[ \t]+", b"", data)
    return data


def _table(text: _Text, kind: bytes, fewest: int) -> Float[np.ndarray, "rows columns"]:
    lines = text.lines(kind)
    if b"," in lines and b"." not in lines:
        lines = lines.replace(b",", b".")
    if _APART.match(lines):
        first = lines.split(b"\n")[0].decode().strip()
        raise BadInput(f"{text.path}: its decimals are parted by blanks ({kind.decode()} {first}); export it again")
    if b"#" in lines:
        lines = re.sub(_NO_NUMBER, b"nan", re.sub(_COMMENT, b"", lines))
    if not lines:
        return np.zeros((0, fewest))
    widths = tokens_by_line(lines)
    if widths.min() < fewest:
        raise BadInput(f"{text.path}: a {kind.decode()} line has fewer than {fewest} numbers: is the file cut off?")
    if widths.max() != widths.min():
        lines = b"\n".join(b" ".join(line.split()[:fewest]) for line in lines.split(b"\n"))
        widths = np.array([fewest])
    return _sound(text, parse_floats(lines), kind).reshape(-1, int(widths[0]))


def _colors(text: _Text, behind: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """What stands behind the vertices as colours in 0..1.

    Raises:
        BadInput: numbers that are no colours: `0 25 1 5 2 75` is three numbers whose decimal commas became blanks.
    """
    low, high = np.nanmin(behind, initial=0.0), np.nanmax(behind, initial=0.0)
    if low < 0 or high > _FULL:
        numbers = f"numbers from {low:g} to {high:g} behind x y z, which are no colours"
        raise BadInput(f"{text.path}: has {numbers}; were its decimal commas lost? export it again")
    return behind / _FULL if high > 1 else behind


def _sound(text: _Text, values: np.ndarray | None, kind: bytes) -> np.ndarray:
    if values is None:
        raise BadInput(f"{text.path}: is no sound OBJ: a {kind.decode()} line does not hold numbers; export it again")
    return values


def _corners(text: _Text) -> tuple[Int[np.ndarray, "corners 2"], Int[np.ndarray, " polygons"]]:
    """Vertex and texture index of every corner as written (0: none), and corners a polygon."""
    lines = text.lines(b"f")
    if b"#" in lines:
        lines = re.sub(_COMMENT, b"", lines)
    if not lines:
        return np.zeros((0, 2), np.int64), np.zeros(0, np.int64)
    counts = tokens_by_line(lines)
    slashes, doubled = _slashes(lines)
    if slashes is None:
        pairs = [[*token.split(b"/"), b"0"][:2] for token in lines.split()]
        written = b" ".join((a or b"0") + b" " + (b or b"0") for a, b in pairs)
        return _sound(text, parse_integers(written), b"f").reshape(-1, 2), counts
    table = _sound(text, parse_integers(lines.replace(b"/", b" ")), b"f").reshape(counts.sum(), slashes + 1 - doubled)
    texture = table[:, 1] if slashes and not doubled else np.zeros(len(table), np.int64)
    return np.stack([table[:, 0], texture], axis=1), counts


def _slashes(lines: bytes) -> tuple[int | None, int]:
    """Slashes and double slashes in every corner, (None, 0) if corners are not written alike."""
    raw = np.frombuffer(lines, np.uint8)
    starts = np.flatnonzero(token_starts(raw))
    slash = raw == ord("/")
    following = np.concatenate([raw[1:], [SPACE]])
    if len(starts) == 0 or slash[starts].any() or (slash & (following <= SPACE)).any():
        return None, 0
    singles = np.add.reduceat(slash, starts, dtype=np.int64)
    doubles = np.add.reduceat(slash & (following == ord("/")), starts, dtype=np.int64)
    if singles.min() != singles.max() or doubles.min() != doubles.max():
        return None, 0
    return int(singles[0]), int(doubles[0])


def _indices(text: _Text, written: np.ndarray, counts: np.ndarray, kind: bytes, n: int) -> Int[np.ndarray, " corners"]:
    """Indices as written (from 1, or back from the last line so far) -> from 0."""
    index = written - 1
    if (written < 0).any():
        so_far = np.cumsum(text.is_kind(kind))[text.is_kind(b"f")]
        index = np.where(written < 0, np.repeat(so_far, counts) + written, index)
    wrong = (index < 0) | (index >= n)
    if wrong.any():
        named = f"{kind.decode()} number {written[np.argmax(wrong)]}"
        raise BadInput(f"{text.path}: a face names {named}, but there are {n}: is the file cut off?")
    return index


def _texture_corners(
    text: _Text, uv: np.ndarray, written: np.ndarray, counts: np.ndarray, triangles: np.ndarray
) -> tuple[Float[np.ndarray, "u 2"], Int[np.ndarray, "m 3"]]:
    """Corners without a texture coordinate get (0, 0)."""
    none = written == 0
    index = _indices(text, np.where(none, 1, written), counts, b"vt", len(uv))
    if none.any():
        index = np.where(none, len(uv), index)
        uv = np.concatenate([uv, np.zeros((1, 2))])
    return uv, index[triangles]


def _pages(text: _Text) -> tuple[Pages, Int[np.ndarray, " polygons"]]:
    """The pictures of the materials that polygons use (None for those without), and which of them each polygon has."""
    pictures, used = pictures_of(text.path, _names(text, b"mtllib")), _names(text, b"usemtl")
    before = np.cumsum(text.is_kind(b"usemtl"))[text.is_kind(b"f")]
    of_material = [None, *(pictures.get(name) for name in used)]
    pages = tuple(dict.fromkeys(of_material[i] for i in np.unique(before)))
    numbers = [pages.index(picture) if picture in pages else 0 for picture in of_material]
    return pages, np.array(numbers, np.int64)[before]


def _names(text: _Text, kind: bytes) -> list[str]:
    """What stands behind each line's first word."""
    return [line.strip().decode("utf-8", "replace") for line in text.lines(kind).split(b"\n")]


def _picture(text: _Text) -> Path | None:
    """The picture of the first material used, else of any, else the one of the same name beside the file."""
    used, pictures = _names(text, b"usemtl"), pictures_of(text.path, _names(text, b"mtllib"))
    beside = [file for suffix in (".png", ".jpg", ".jpeg") if (file := text.path.with_suffix(suffix)).is_file()]
    first = [pictures[name] for name in used if name in pictures]
    return next(iter([*first, *pictures.values(), *beside]), None)
