"""Meshes and mesh files made by hand."""

from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.meshes import read_scan
from mien.mesh import Mesh

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


TWO = np.array([[0, 1, 2], [0, 2, 3]])


def refusal(path: Path, content: str | bytes | None = None) -> str:
    if content is not None:
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(BadInput) as caught:
        read_scan(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def bumpy(n: int = 40, colors: bool = False, uv: str = "none") -> Mesh:
    rng = np.random.default_rng(2)
    vertices = rng.normal(0, 60, (n, 3))
    faces = np.array([rng.permutation(n)[:3] for _ in range(2 * n)])
    options: dict = {"colors": rng.integers(0, 256, (n, 3)) / 255.0} if colors else {}
    if uv == "vertex":
        options["uv"] = rng.random((n, 2))
    if uv == "corner":
        options |= {"uv": rng.random((n + 7, 2)), "uv_faces": rng.integers(0, n + 7, (2 * n, 3))}
    return Mesh(vertices, faces, **options)
