"""A face as a page's GPU takes it: texels instead of vertices, lists of neighbours, smooth subdivision as sums."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float, Int, Real

from ..blendshapes.build.masks import REGIONS, TexturedRig, share_gram
from ..faces import load_face
from ..io.gltf.mesh import split_seams
from ..mesh import Mesh, loop_refinement, subdivided
from ..pictures.eyes import eyeballs
from ..pictures.occlusion import ambient_occlusion
from ..pictures.show import rig_look
from ..rig import Rig
from .scene_file import SceneWriter

WIDTH = 512
"""Of textures that hold one vertex a texel; the page's shaders know it too."""

STEPS = 32767
"""Of a displacement's range to either side: 16 bits, a thousandth of a millimetre for one of 30 mm."""

RAYS = (16, 64)
"""Rays a vertex for ambient occlusion: fewest for the largest meshes, most for small ones."""
ALL_RAYS = 2_000_000
"""About as many rays as a second has."""

OPENS = "jawOpen"
"""The shape that lets light into the mouth."""


def face_of(rig: Rig, scene: SceneWriter) -> dict[str, Any]:
    """Everything that stays the same over a performance: surface, shapes, colours, materials, what the sky sees."""
    fine = refined(rig.neutral)
    faces, source, uv = split_seams(fine.mesh)
    deltas, steps = quantised(rig.deltas)
    count = len(fine.mesh.vertices)
    closed, opened = skies(rig, fine)
    told = {
        "vertices": len(rig.neutral.vertices),
        "fine": count,
        "names": list(rig.names),
        "neutral": scene.array(texels(rig.neutral.vertices, 4), "f4"),
        "deltas": scene.array(deltas, "i2"),
        "steps": scene.array(steps, "f4"),
        "faces": scene.array(faces, "u4"),
        "source": scene.array(source, "u4"),
        "around": listed(scene, *neighbours(fine.mesh.faces, count)),
        "sky": scene.array(np.stack([closed, opened], axis=1)[source], "f4"),
        "opens": rig.names.index(OPENS) if OPENS in rig.names else -1,
        "material": scene.array((fine.between @ materials(rig.neutral))[source], "f4"),
    }
    if fine.rounds:
        told["subdivide"] = listed(scene, *rows_of(fine.matrix))
    if uv is not None and rig.texture is not None:
        told |= {"uv": scene.array(uv, "f4"), "texture": scene.picture(rig.texture)}
    if fine.mesh.colors is not None:
        told["colors"] = scene.array(fine.mesh.colors[source], "f4")
    return told


def textures_in_step(textured: TexturedRig, names: Sequence[str], scene: SceneWriter) -> dict[str, Any]:
    """What blends textures with the shapes (Casas et al. 2016, eq. 3 and sec. 5.2).

    The base texture, each capture's, the regions' masks as one picture, and what finds shares from weights.

    names: of the shapes that the page has weights of; one that the rig lacks has no texture.
    """
    base = textured.rig.texture
    assert base is not None
    mixes = np.zeros((len(textured.captures), len(names)))
    for k, name in enumerate(names):
        if name in textured.rig.names:
            mixes[:, k] = textured.mixes[:, textured.rig.index(name)]
    masks = np.stack([textured.mask_textures[region] for region in REGIONS], -1)
    regions = [[float(region in kept) for region in REGIONS] for kept in textured.regions]
    return {
        "texture": scene.picture(base),
        "captures": [scene.picture(picture) for picture in textured.textures],
        "masks": scene.picture((masks * 255).round().astype(np.uint8)),
        "regions": scene.array(np.array(regions).reshape(-1, len(REGIONS)), "f4"),
        "gram": scene.array(share_gram(textured.mixes), "f4"),
        "mixes": scene.array(mixes, "f4"),
    }


@dataclass(frozen=True)
class RefinedMesh:
    """A coarse mesh made round."""

    mesh: Mesh
    matrix: sp.csr_matrix
    """(fine, coarse): positions."""
    between: sp.csr_matrix
    """(fine, coarse): values carried straight along edges."""
    rounds: int


def refined(mesh: Mesh) -> RefinedMesh:
    """As many rounds of smooth subdivision as pictures give a rig of that size."""
    rounds = rig_look(mesh).refine
    matrix = between = sp.csr_matrix(sp.identity(len(mesh.vertices)))
    for _ in range(rounds):
        step = loop_refinement(mesh.faces, len(mesh.vertices))
        mesh = subdivided(mesh, step)
        matrix = sp.csr_matrix(step.matrix @ matrix)
        between = sp.csr_matrix(step.between @ between)
    return RefinedMesh(mesh, matrix, between, rounds)


def quantised(deltas: Float[np.ndarray, "k n 3"]) -> tuple[Int[np.ndarray, "k texels 3"], Float[np.ndarray, " k"]]:
    """Displacements as 16-bit texels, and the millimetres of one step of each shape."""
    steps = np.abs(deltas).max(axis=(1, 2), initial=0.0) / STEPS
    out = np.zeros((len(deltas), full_rows(deltas.shape[1]), 3), np.int16)
    for k, step in enumerate(steps):
        if step > 0:
            out[k, : deltas.shape[1]] = np.round(deltas[k] / step)
    return out, steps


def full_rows(count: int) -> int:
    """`count` rounded up to whole rows of a texture, one row at least."""
    return max(-(-count // WIDTH), 1) * WIDTH


def texels(values: Real[np.ndarray, "n c"], channels: int) -> Float[np.ndarray, "texels _"]:
    """Values filled up to whole rows and `channels`."""
    out = np.zeros((full_rows(len(values)), channels), np.float32)
    out[: len(values), : values.shape[1]] = values
    return out


def neighbours(faces: Int[np.ndarray, "m 3"], n: int) -> tuple[Int[np.ndarray, "n 2"], Int[np.ndarray, "c 2"]]:
    """For every vertex the other two corners of each triangle around it, in the triangle's order.

    Returns:
        first entry and number of entries of each vertex; the entries.
    """
    vertex = faces.ravel()
    pairs = np.stack([np.roll(faces, -1, axis=1).ravel(), np.roll(faces, -2, axis=1).ravel()], axis=1)
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex, minlength=n)
    return np.stack([np.cumsum(counts) - counts, counts], axis=1), pairs[order]


def rows_of(matrix: sp.csr_matrix) -> tuple[Int[np.ndarray, "n 2"], Float[np.ndarray, "c 2"]]:
    """A sparse matrix as lists: first entry and number of entries of each row; (column, value) of the entries."""
    starts = matrix.indptr[:-1]
    counts = np.diff(matrix.indptr)
    return np.stack([starts, counts], axis=1), np.stack([matrix.indices, matrix.data], axis=1)


def listed(scene: SceneWriter, spans: np.ndarray, entries: np.ndarray) -> dict[str, Any]:
    """Lists as two textures of pairs."""
    return {"spans": scene.array(texels(spans, 2), "f4"), "entries": scene.array(texels(entries, 2), "f4")}


def skies(rig: Rig, fine: RefinedMesh) -> tuple[Float[np.ndarray, " fine"], Float[np.ndarray, " fine"]]:
    """How much of the sky each vertex sees, 0..1, with the mouth closed and with the jaw open."""
    mesh = rig.neutral
    rays = int(np.clip(ALL_RAYS // max(len(mesh.vertices), 1), *RAYS))
    closed = ambient_occlusion(mesh, rays)
    opened = closed
    if OPENS in rig.names:
        shape = mesh.vertices + rig.deltas[rig.names.index(OPENS)]
        opened = ambient_occlusion(mesh.with_vertices(shape), rays)
    return fine.between @ closed, fine.between @ opened


def materials(mesh: Mesh) -> Float[np.ndarray, "n 2"]:
    """How much of an eye and of a tooth each vertex is, 0..1; teeth are known on the bundled face alone."""
    out = np.zeros((len(mesh.vertices), 2))
    out[:, 0] = eyeballs(mesh)
    face = load_face()
    if np.array_equal(face.rig.neutral.faces, mesh.faces):
        out[np.concatenate([face.parts["upper_teeth"], face.parts["lower_teeth"]]), 1] = 1.0
    return out
