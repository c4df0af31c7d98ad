"""The GLB container and glTF's accessors: binary arrays behind a JSON index (glTF 2.0, sections 3.6 and 4)."""

import base64
import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ...errors import BadInput
from ...files import existing, whole

_MAGIC, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_COMPRESSED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


@dataclass(frozen=True)
class Glb:
    """An open `.glb`: its JSON and its binary chunk."""

    path: Path
    json: dict[str, Any]
    blob: bytes

    def view(self, index: int) -> tuple[int, int, int]:
        """(first byte, length, stride; 0 = packed) of a buffer view in `blob`.

        Raises:
            BadInput: it lies outside, or in another file.
        """
        view = self.json["bufferViews"][index]
        if view.get("buffer", 0) != 0 or "uri" in self.json["buffers"][0]:
            raise BadInput(f"{self.path}: keeps data outside its own binary chunk; export it as one .glb")
        start, length = view.get("byteOffset", 0), view["byteLength"]
        if start + length > len(self.blob):
            raise BadInput(f"{self.path}: is cut off: a buffer view ends at byte {start + length} of {len(self.blob)}")
        return start, length, view.get("byteStride", 0)

    def accessor(self, index: int) -> np.ndarray:
        """An accessor as (count, width) array, (count,) if scalar; floats as float64, normalised integers as 0..1.

        Sparse accessors, strides and missing buffer views (zeros) are resolved.
        """
        accessor = self.json["accessors"][index]
        count, width = accessor["count"], _WIDTHS[accessor["type"]]
        dtype = np.dtype(_COMPONENTS[accessor["componentType"]])
        if "bufferView" in accessor:
            values = self._array(accessor["bufferView"], accessor.get("byteOffset", 0), count, width, dtype)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            values = values.copy()
            sparse = accessor["sparse"]
            at, to = sparse["indices"], sparse["values"]
            at_type = np.dtype(_COMPONENTS[at["componentType"]])
            rows = self._array(at["bufferView"], at.get("byteOffset", 0), sparse["count"], 1, at_type)[:, 0]
            values[rows] = self._array(to["bufferView"], to.get("byteOffset", 0), sparse["count"], width, dtype)
        if accessor.get("normalized"):
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)
        elif dtype.kind == "f":
            values = values.astype(np.float64)
        return values[:, 0] if width == 1 else values

    def _array(self, view: int, offset: int, count: int, width: int, dtype: np.dtype) -> np.ndarray:
        start, length, stride = self.view(view)
        stride = stride or width * dtype.itemsize
        if count and offset + (count - 1) * stride + width * dtype.itemsize > length:
            raise BadInput(f"{self.path}: is damaged: an accessor of {count} items is longer than its buffer view")
        strides = (stride, dtype.itemsize)
        return np.ndarray((count, width), dtype, self.blob, start + offset, strides)


def open_glb(path: str | Path) -> Glb:
    """Read a `.glb` (or `.vrm`), or a `.gltf` with its buffers and pictures, whole.

    Raises:
        BadInput: missing, not GLB, cut off, compressed.
    """
    path = existing(path)
    data = path.read_bytes()
    if data.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"{":
        return read_gltf(path, data)
    if len(data) < 20 or struct.unpack_from("<I", data)[0] != _MAGIC:
        raise BadInput(f"{path}: is not a .glb file (it does not start with glTF); export binary glTF 2.0")
    _, version, length = struct.unpack_from("<III", data)
    if version != 2:
        raise BadInput(f"{path}: is glTF version {version}; export glTF 2.0")
    if len(data) < length:
        raise BadInput(f"{path}: is cut off: {len(data)} of {length} bytes are there; copy or export it again")
    chunks = dict(_chunks(path, data[:length]))
    with damage_told(path):
        content = json.loads(chunks[_JSON])
        _refuse_compression(path, content)
    return Glb(path, content, chunks.get(_BIN, b""))


def _refuse_compression(path: Path, content: dict[str, Any]) -> None:
    compressed = _COMPRESSED & set(content.get("extensionsUsed", []))
    if compressed:
        raise BadInput(
            f"{path}: is compressed ({', '.join(sorted(compressed))}); export it without compression, or: "
            f"npx @gltf-transform/cli copy {path.name} {path.stem}-plain.glb"
        )


def read_gltf(path: Path, data: bytes) -> Glb:
    """A `.gltf` with its buffers and pictures, from files beside it or data URIs, as if it were one `.glb`.

    Raises:
        BadInput: damaged, compressed, a file that it names is not there.
    """
    with damage_told(path):
        content = json.loads(data.decode("utf-8-sig"))
        version = str((content.get("asset") or {}).get("version", ""))
        if not version.startswith("2"):
            raise BadInput(f"{path}: is glTF version {version or 'unknown'}; export glTF 2.0")
        _refuse_compression(path, content)
        blob, starts = bytearray(), []
        for buffer in content.get("buffers", []):
            starts.append(len(blob))
            blob += _resource(path, buffer["uri"])[: buffer["byteLength"]]
            blob += b"\0" * (-len(blob) % 4)
        for view in content.get("bufferViews", []):
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view.get("buffer", 0)]
            view["buffer"] = 0
        for image in content.get("images", []):
            if "uri" in image:
                uri = image.pop("uri")
                picture = _resource(path, uri)
                image["mimeType"] = image.get("mimeType") or (
                    "image/png" if picture[:4] == b"\x89PNG" else "image/jpeg"
                )
                image["bufferView"] = len(content.setdefault("bufferViews", []))
                content["bufferViews"].append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(picture)})
                blob += picture + b"\0" * (-len(picture) % 4)
        content["buffers"] = [{"byteLength": len(blob)}]
    return Glb(path, content, bytes(blob))


def _resource(path: Path, uri: str) -> bytes:
    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2])
    file = path.parent / unquote(uri)
    if not file.is_file():
        raise BadInput(f"{path}: names {uri}, which is not beside it; copy the whole folder, or export one .glb")
    return file.read_bytes()


@contextmanager
def damage_told(path: Path) -> Iterator[None]:
    """Turn what goes wrong when a broken file is taken apart into one BadInput line."""
    try:
        with np.errstate(invalid="raise", divide="raise"):
            yield
    except BadInput:
        raise
    except (LookupError, ValueError, ArithmeticError, AttributeError, TypeError, OSError, MemoryError) as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0]
        raise BadInput(f"{path}: is damaged or no valid glTF ({what}); export it again") from error


@dataclass
class GlbBuilder:
    """Collects arrays for a `.glb`; `json` is filled in by whoever builds, and `save` writes both."""

    json: dict[str, Any] = field(default_factory=lambda: {"asset": {"version": "2.0", "generator": "mien"}})
    _blob: bytearray = field(default_factory=bytearray)

    def add(self, key: str, item: dict[str, Any]) -> int:
        """Append to one of glTF's top-level lists; gives the index."""
        self.json.setdefault(key, []).append(item)
        return len(self.json[key]) - 1

    def view(self, data: bytes, target: int | None = None) -> int:
        """Bytes as a buffer view of their own, on a multiple of four."""
        self._blob += b"\0" * (-len(self._blob) % 4)
        view = {"buffer": 0, "byteOffset": len(self._blob), "byteLength": len(data)}
        self._blob += data
        return self.add("bufferViews", view if target is None else view | {"target": target})

    def accessor(self, values: np.ndarray, target: int | None = None, bounds: bool = False, **more: Any) -> int:
        """An array (n,) or (n, width) of float32, uint8, uint16 or uint32 as accessor; `bounds` writes min and max."""
        head = _accessor_head(values, bounds) | more
        return self.add("accessors", {"bufferView": self.view(values.tobytes(), target), **head})

    def sparse_accessor(self, values: np.ndarray, **more: Any) -> int:
        """As `accessor` with bounds, but only rows that are not all zero are stored where that is smaller."""
        rows = np.flatnonzero((values != 0).any(axis=1))
        rows = rows if len(rows) else np.zeros(1, np.int64)
        index_type = np.dtype("<u2" if len(values) <= 0xFFFF else "<u4")
        overhead = 300
        if len(rows) * (index_type.itemsize + values[:1].nbytes) + overhead >= values.nbytes:
            return self.accessor(values, ARRAY_BUFFER, bounds=True, **more)
        code = {"<u2": 5123, "<u4": 5125}[index_type.str]
        indices = {"bufferView": self.view(rows.astype(index_type).tobytes()), "componentType": code}
        kept = {"bufferView": self.view(values[rows].tobytes())}
        sparse = {"count": len(rows), "indices": indices, "values": kept}
        return self.add("accessors", _accessor_head(values, True) | more | {"sparse": sparse})

    def save(self, path: str | Path) -> None:
        """Write the `.glb`, whole or not at all.

        Raises:
            BadInput: the folder does not exist.
        """
        self._blob += b"\0" * (-len(self._blob) % 4)
        content = self.json | {"buffers": [{"byteLength": len(self._blob)}]}
        text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        head = struct.pack("<III", _MAGIC, 2, 12 + 8 + len(text) + 8 + len(self._blob))
        with whole(path) as temporary, temporary.open("wb") as file:
            file.write(head + struct.pack("<II", len(text), _JSON) + text)
            file.write(struct.pack("<II", len(self._blob), _BIN) + self._blob)


def _accessor_head(values: np.ndarray, bounds: bool) -> dict[str, Any]:
    code = next(code for code, name in _COMPONENTS.items() if np.dtype(name) == values.dtype)
    width = 1 if values.ndim == 1 else values.shape[1]
    kind = next(name for name, w in _WIDTHS.items() if w == width)
    head = {"componentType": code, "count": len(values), "type": kind}
    if bounds:
        table = values.reshape(len(values), width)
        head |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
    return head


def _chunks(path: Path, data: bytes) -> Iterator[tuple[int, bytes]]:
    at = 12
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        if at + 8 + length > len(data):
            raise BadInput(f"{path}: is cut off inside a chunk; copy or export it again")
        yield kind, data[at + 8 : at + 8 + length]
        at += 8 + length
