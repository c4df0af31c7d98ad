"""PLY (Turk 1994), text and binary: vertex order kept exactly, colours, texture coordinates by vertex or by corner."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int, UInt8

from ...errors import BadInput
from ...files import existing, whole
from ...mesh import Mesh
from ...text.parse_numbers import parse_floats, tokens_by_line
from .images import write_image
from .materials import file_beside
from .ply_header import PlyElement, PlyProperty, read_ply_header
from .polygons import fan, strip_triangles, weld
from .texture_pages import Pages, mesh_on_pages


@dataclass(frozen=True)
class _Column:
    """One property of all rows of an element."""

    items: np.ndarray
    """One value a row, or the rows' lists one after another."""
    counts: Int[np.ndarray, " rows"]
    """Items a row; all ones for a plain value."""


_Columns = dict[str, _Column]
_NONE = _Column(np.zeros(0, np.int64), np.zeros(0, np.int64))


def read_ply(path: str | Path) -> tuple[Mesh, Path | Pages | None]:
    """The mesh of a PLY file in the file's unit, and where its colour picture is, or its several pages are.

    Polygons become fans of triangles, strips (`tristrips`) triangles. Pictures are those that `comment TextureFile`
    names; where there are several, each face's `texnumber` says which is its own (see `texture_pages`).

    Raises:
        BadInput: missing, not PLY, cut off, no vertices.
    """
    path = existing(path)
    data = path.read_bytes()
    header = read_ply_header(path, data)
    if header.end == "":
        columns = _read_text(path, header.elements, data[header.body :])
    else:
        columns = _read_binary(path, header.elements, data, header.body, header.end)
    vertex, face = columns.get("vertex", {}), columns.get("face", {})
    if not {"x", "y", "z"} <= set(vertex):
        raise BadInput(f"{path}: has no vertices with x, y, z")
    vertices = _stack(vertex, "xyz")
    corners = _corner_lists(face)
    triangles = fan(corners.counts)
    with np.errstate(invalid="ignore"):
        faces = corners.items.astype(np.int64)[triangles]
        strips = strip_triangles(*_list_of(_corner_lists(columns.get("tristrips", {}))))
    faces = np.concatenate([faces, strips])
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise BadInput(f"{path}: a face names vertex {faces.max()}, but there are {len(vertices)}; export it again")
    uv, uv_faces = _uv(vertex, face, corners, triangles)
    if len(strips) and uv_faces is not None:
        uv, uv_faces = None, None
    mesh = Mesh(vertices, faces, uv, uv_faces, _colors(vertex))
    pages = [file_beside(path.parent, name) for name in header.pictures]
    there = [page for page in pages if page is not None]
    if uv is None or not there:
        return mesh, None
    if len(pages) < 2 or "texnumber" not in face or len(there) < len(pages):
        return mesh, there[0]
    number = np.repeat(face["texnumber"].items.astype(np.int64), np.maximum(corners.counts - 2, 0))
    numbered = (number >= 0) & (number < len(there))
    paths = there if numbered.all() else [*there, None]
    return mesh_on_pages(mesh, np.where(numbered, number, len(there)), paths), tuple(paths)


def _corner_lists(face: _Columns) -> _Column:
    """The lists of vertices, under any of their names."""
    return face.get("vertex_indices", face.get("vertex_index", _NONE))


def _list_of(column: _Column) -> tuple[Int[np.ndarray, " items"], Int[np.ndarray, " rows"]]:
    return column.items.astype(np.int64), column.counts


def write_ply(path: str | Path, mesh: Mesh, texture: UInt8[np.ndarray, "h w 3"] | None = None) -> None:
    """Write a mesh as binary PLY in its own unit (millimetres), float32, colours 8 bit; with `texture` also STEM.png.

    Raises:
        BadInput: the folder does not exist.
    """
    path = Path(path)
    corner_uv = mesh.uv is not None and mesh.uv_faces is not None
    vertex = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    vertex += [("s", "<f4"), ("t", "<f4")] if mesh.uv is not None and not corner_uv else []
    vertex += [("red", "u1"), ("green", "u1"), ("blue", "u1")] if mesh.colors is not None else []
    rows = np.zeros(len(mesh.vertices), vertex)
    for i, axis in enumerate("xyz"):
        rows[axis] = mesh.vertices[:, i]
    if mesh.uv is not None and not corner_uv:
        rows["s"], rows["t"] = mesh.uv.T
    if mesh.colors is not None:
        for i, name in enumerate(("red", "green", "blue")):
            rows[name] = np.round(np.clip(mesh.colors[:, i], 0, 1) * 255)
    triangle = [("k", "u1"), ("v", "<i4", 3), ("l", "u1"), ("w", "<f4", 6)]
    faces = np.zeros(len(mesh.faces), triangle if corner_uv else triangle[:2])
    faces["k"], faces["v"] = 3, mesh.faces
    if mesh.uv is not None and mesh.uv_faces is not None:
        faces["l"], faces["w"] = 6, mesh.uv[mesh.uv_faces].reshape(-1, 6)
    header = ["ply", "format binary_little_endian 1.0", "comment millimetres"]
    if texture is not None and mesh.uv is not None:
        write_image(path.with_suffix(".png"), texture)
        header.append(f"comment TextureFile {path.stem}.png")
    header.append(f"element vertex {len(rows)}")
    header += [f"property {'uchar' if kind == 'u1' else 'float'} {name}" for name, kind in vertex]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header += ["property list uchar float texcoord"] if corner_uv else []
    with whole(path) as temporary, temporary.open("wb") as file:
        file.write("\n".join([*header, "end_header", ""]).encode() + rows.tobytes() + faces.tobytes())


def _read_text(path: Path, elements: list[PlyElement], body: bytes) -> dict[str, _Columns]:
    """Text is read as if it were binary with every number a double: a row a line, whatever else the line holds."""
    doubles = []
    for element in elements:
        properties = [PlyProperty(p.name, "f8", "f8" if p.count else "") for p in element.properties]
        doubles.append(PlyElement(element.name, element.size, properties))
    values = parse_floats(body)
    if values is None or _length(doubles, values) != len(values) or not _ends_with_a_line(doubles[0], body):
        values = parse_floats(b"\n".join(_needed_of_lines(path, doubles, body)))
    if values is None:
        raise BadInput(f"{path}: is damaged: its body does not hold numbers alone; export it again")
    return _read_binary(path, doubles, values.astype("<f8").tobytes(), 0, "<")


def _length(elements: list[PlyElement], values: Float[np.ndarray, " v"]) -> int:
    """How many numbers the elements take if their lists are as long as in the first row; -1 where they cannot."""
    at = 0
    for element in elements:
        row = 0
        for p in element.properties if element.size else ():
            if p.count and at + row >= len(values):
                return -1
            row += 1 + int(np.nan_to_num(values[at + row])) if p.count else 1
        at += row * element.size
    return at


def _ends_with_a_line(first: PlyElement, body: bytes) -> bool:
    """Whether the first element's rows do; where a row is missing they run into the next element, by chance unseen."""
    if any(p.count for p in first.properties):
        return True
    width = first.size * len(first.properties)
    return width == 0 or width in np.cumsum(tokens_by_line(body))


def _needed_of_lines(path: Path, elements: list[PlyElement], body: bytes) -> Iterator[bytes]:
    """Of every line the words that its element's properties take: exporters add some that the header does not name."""
    lines = (words for line in body.splitlines() if (words := line.split()))
    for element in elements:
        for _ in range(element.size):
            words = next(lines, None)
            if words is None:
                have = f"fewer than the {element.size} rows of {element.name} that it promises"
                raise BadInput(f"{path}: is cut off: it has {have}; copy or export it again")
            at = 0
            for p in element.properties:
                at += 1 + _count(path, words, at) if p.count else 1
            if at > len(words):
                raise BadInput(f"{path}: is cut off or damaged: a row of {element.name} is too short; export it again")
            yield b" ".join(words[:at])


def _count(path: Path, words: list[bytes], at: int) -> int:
    """The length of the list that begins at word `at`."""
    try:
        return max(0, int(float(words[at])))
    except (ValueError, IndexError, OverflowError):
        raise BadInput(f"{path}: is cut off or damaged: a list has no length; export it again") from None


def _read_binary(path: Path, elements: list[PlyElement], data: bytes, at: int, end: str) -> dict[str, _Columns]:
    columns = {}
    for element in elements:
        try:
            same = _rows_alike(element, data, at, end)
            columns[element.name], at = same or _rows_of_any_length(element, data, at, end)
        except ValueError as error:
            have = f"fewer than the {element.size} rows of {element.name} that it promises"
            raise BadInput(f"{path}: is cut off: it has {have}; copy or export it again") from error
    return columns


def _rows_alike(element: PlyElement, data: bytes, at: int, end: str) -> tuple[_Columns, int] | None:
    """All rows at once, if every list has as many items as in the first row; else None."""
    fields, counts, place = [], {}, at
    for i, p in enumerate(element.properties):
        kind = np.dtype(end + p.kind)
        if p.count:
            count = np.dtype(end + p.count)
            counts[i] = int(np.frombuffer(data, count, 1, place)[0]) if element.size else 0
            fields += [(f"n{i}", count), (f"p{i}", kind, (counts[i],))]
            place += count.itemsize + counts[i] * kind.itemsize
        else:
            fields.append((f"p{i}", kind))
            place += kind.itemsize
    row = np.dtype(fields)
    if counts and at + element.size * row.itemsize > len(data):
        return None
    table = np.frombuffer(data, row, element.size, at) if element.size else np.zeros(0, row)
    if any((table[f"n{i}"] != n).any() for i, n in counts.items()):
        return None
    out = {}
    for i, p in enumerate(element.properties):
        out[p.name] = _Column(table[f"p{i}"].reshape(-1), np.full(element.size, counts.get(i, 1)))
    return out, at + element.size * row.itemsize


def _rows_of_any_length(element: PlyElement, data: bytes, at: int, end: str) -> tuple[_Columns, int]:
    kinds = [(np.dtype(end + p.count) if p.count else None, np.dtype(end + p.kind)) for p in element.properties]
    counts = [[] for _ in kinds]
    items = [[] for _ in kinds]
    for _ in range(element.size):
        for i, (count, kind) in enumerate(kinds):
            n = 1
            if count is not None:
                n = int(np.frombuffer(data, count, 1, at)[0])
                at += count.itemsize
            counts[i].append(n)
            items[i].append(np.frombuffer(data, kind, n, at))
            at += n * kind.itemsize
    columns = zip(element.properties, items, counts, strict=True)
    return {p.name: _Column(np.concatenate(flat), np.array(n, np.int64)) for p, flat, n in columns}, at


def _stack(columns: _Columns, names: Iterable[str]) -> Float[np.ndarray, "rows columns"]:
    return np.stack([columns[name].items.astype(np.float64) for name in names], axis=1)


def _colors(vertex: _Columns) -> Float[np.ndarray, "n 3"] | None:
    for names in (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")):
        if set(names) <= set(vertex):
            whole_numbers = vertex[names[0]].items.dtype.kind == "u" or _stack(vertex, names).max(initial=0) > 1
            return _stack(vertex, names) / (255.0 if whole_numbers else 1.0)
    return None


def _uv(
    vertex: _Columns, face: _Columns, corners: _Column, triangles: Int[np.ndarray, "m 3"]
) -> tuple[Float[np.ndarray, "u 2"] | None, Int[np.ndarray, "m 3"] | None]:
    texcoord = face.get("texcoord", _NONE)
    if len(triangles) and np.array_equal(texcoord.counts, 2 * corners.counts):
        uv = texcoord.items.astype(np.float64).reshape(-1, 2)
        place = weld(uv)
        return uv[np.unique(place, return_index=True)[1]], place[triangles]
    for names in (("s", "t"), ("u", "v"), ("texture_u", "texture_v")):
        if set(names) <= set(vertex):
            return _stack(vertex, names), None
    return None, None
