"""Rigs and performances as glTF (`.glb`), out and in again.

Metres, +Y up, +Z out of the face: glTF's own frame. Numbers are float32: a round trip moves a vertex by up to 1e-5 mm.
Morph targets are displacements from the rig's neutral, of positions and normals, named in `mesh.extras.targetNames`.
Two nodes: `head` bears the pose, its child `face` the mesh.

glTF has one texture coordinate a vertex, the rig one a corner: vertices on seams are written several times. The first n
stand in the rig's order; the attribute `_SOURCE` holds for all of them the rig's vertex, by which reading puts the rig
together again. Files of other programs have no `_SOURCE`; there, vertices that agree in position and in all
displacements become one.
"""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from ...files import note_clock
from ...rig import Performance, Rig
from ...rig.morph_normals import neutral_normals, normal_offsets
from ...rig.unit_weights import joined, with_unit_weights
from ...transforms import Transform, quaternions_from_rotations
from ..meshes.polygons import weld
from .animation import face_motion, weight_animation
from .glb import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, Glb, GlbBuilder, damage_told, open_glb
from .mesh import (
    MM,
    SKIN_LINEAR,
    SKIN_ROUGHNESS,
    PrimitiveSurface,
    linear_from_srgb,
    png_bytes,
    read_surface,
    split_seams,
)
from .scene import chain_of, default_matrix, morph_mesh_node
from .shapes import shape_deltas, shape_names

_NOTHING_MM = 1e-6
"""Displacements below this are written as none: less than float32 can say about a position."""


def write_rig(path: str | Path, rig: Rig) -> None:
    """Write a rig as `.glb`.

    Raises:
        BadInput: the folder does not exist.
    """
    _with_rig(rig).save(path)


def write_performance(path: str | Path, performance: Performance) -> None:
    """Write a performance as `.glb`: the rig, one animation of its weights and of the head's pose, linear in between.

    Weights are written in 0..1 (`rig.unit_weights`), since viewers clamp them. Time 0 is the first frame. The node
    `head` has `extras`: `rate` in frames a second, `untracked`, a list of frames.

    Raises:
        ValueError: the head pose scales, or there is no frame.
        BadInput: the folder does not exist.
    """
    if performance.T_world_face.scale != 1.0 or len(performance) == 0:
        raise ValueError("T_world_face, weights: expected one rigid pose a frame and at least one frame")
    performance = with_unit_weights(performance)
    build = _with_rig(performance.rig)
    _add_animation(build, performance)
    untracked = np.flatnonzero(~performance.tracked).tolist()
    build.json["nodes"][0]["extras"] = {"rate": performance.rate, "untracked": untracked}
    build.save(path)
    note_clock(path, performance.rate, len(performance))


def read_rig(path: str | Path) -> Rig:
    """The rig of a `.glb`: the mesh with the most morph targets (then vertices), in its scene's rest pose, millimetres.

    All triangles of that mesh are read, whatever their material; the texture is the base colour of the largest part.
    Names come from `mesh.extras.targetNames`, else from the targets' accessors, else they are `target_000`, ...

    Raises:
        BadInput: missing, not GLB, cut off, damaged, compressed, no morph targets, targets of another vertex count,
            targets of the same name.
    """
    glb = open_glb(path)
    with damage_told(glb.path):
        node, mesh = morph_mesh_node(glb)
        rig = _rig(glb, mesh, default_matrix(glb, chain_of(glb, node)))
    return joined(rig, np.zeros((0, len(rig.names))))[0]


def read_performance(path: str | Path) -> Performance:
    """The rig of a `.glb` (see `read_rig`) and the animation of its weights and of the nodes above its mesh.

    Shapes that were split into companions for the sake of clamping are whole again, and their weights signed.
    Keys that are not evenly spaced are resampled at `extras.rate`, else at their median spacing.

    Raises:
        BadInput: as `read_rig`; no animation of the morph weights; a node above the mesh changes size.
    """
    glb = open_glb(path)
    with damage_told(glb.path):
        node, mesh = morph_mesh_node(glb)
        chain = chain_of(glb, node)
        rest = default_matrix(glb, chain)
        rig = _rig(glb, mesh, rest)
        weights, times, rate, animation = weight_animation(glb, chain, len(rig.names))
        motion = face_motion(glb, chain, animation, times, rest)
        extras = [glb.json["nodes"][n].get("extras") or {} for n in chain]
        untracked = [frame for extra in extras for frame in extra.get("untracked", [])]
        tracked = np.ones(len(weights), dtype=bool)
        tracked[untracked] = False
    rig, weights = joined(rig, weights)
    return Performance(rig, weights, Transform(motion.rotation, motion.translation / MM), rate, tracked)


# --- out ---------------------------------------------------------------------------------------------------------


def _with_rig(rig: Rig) -> GlbBuilder:
    build = GlbBuilder()
    faces, source, uv = split_seams(rig.neutral)
    normals = neutral_normals(rig)
    attributes = _attributes(build, rig, normals, source, uv)
    shift = np.where(np.abs(rig.deltas).max(axis=2, keepdims=True) < _NOTHING_MM, 0.0, rig.deltas) * MM
    targets = []
    for k, name in enumerate(rig.names):
        place = build.sparse_accessor(shift[k][source].astype(np.float32), name=name)
        turn = build.sparse_accessor(normal_offsets(rig, k, normals)[source].astype(np.float32))
        targets.append({"POSITION": place, "NORMAL": turn})
    indices = build.accessor(faces.astype(np.uint32).ravel(), ELEMENT_ARRAY_BUFFER)
    primitive = {"attributes": attributes, "indices": indices, "material": _material(build, rig)}
    mesh: dict[str, Any] = {"name": "face", "primitives": [primitive]}
    if targets:
        primitive["targets"] = targets
        mesh |= {"weights": [0.0] * len(targets), "extras": {"targetNames": list(rig.names)}}
    build.add("meshes", mesh)
    build.add("nodes", {"name": "head", "children": [1]})
    build.add("nodes", {"name": "face", "mesh": 0})
    build.json |= {"scenes": [{"nodes": [0]}], "scene": 0}
    return build


def _attributes(
    build: GlbBuilder, rig: Rig, normals: np.ndarray, source: np.ndarray, uv: np.ndarray | None
) -> dict[str, int]:
    mesh = rig.neutral
    columns = {
        "POSITION": (mesh.vertices * MM)[source],
        "NORMAL": normals[source],
        "_SOURCE": source,
    }
    if uv is not None:
        columns["TEXCOORD_0"] = uv * (1, -1) + (0, 1)
    if mesh.colors is not None:
        # COLOR_0 multiplies the texture, so beside a texture it goes by a name that no viewer draws.
        columns["COLOR_0" if rig.texture is None else "_COLOR"] = linear_from_srgb(mesh.colors)[source]
    return {
        name: build.accessor(values.astype(np.float32), ARRAY_BUFFER, bounds=name == "POSITION")
        for name, values in columns.items()
    }


def _material(build: GlbBuilder, rig: Rig) -> int:
    surface: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": SKIN_ROUGHNESS}
    if rig.texture is not None and rig.neutral.uv is not None:
        image = build.view(png_bytes(rig.texture))
        source = build.add("images", {"bufferView": image, "mimeType": "image/png"})
        surface["baseColorTexture"] = {"index": build.add("textures", {"source": source})}
    elif rig.neutral.colors is None:
        surface["baseColorFactor"] = [*SKIN_LINEAR, 1.0]
    return build.add("materials", {"name": "skin", "pbrMetallicRoughness": surface, "doubleSided": True})


def _add_animation(build: GlbBuilder, performance: Performance) -> None:
    times = (np.arange(len(performance)) / performance.rate).astype(np.float32)
    clock = build.accessor(times, bounds=True)
    pose = performance.T_world_face
    channels = (
        (1, "weights", performance.weights.ravel()),
        (0, "translation", pose.translation * MM),
        (0, "rotation", quaternions_from_rotations(pose.rotation)),
    )
    samplers, targets = [], []
    for node, path, values in channels:
        output = build.accessor(values.astype(np.float32))
        targets.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
        samplers.append({"input": clock, "output": output, "interpolation": "LINEAR"})
    build.add("animations", {"name": "performance", "channels": targets, "samplers": samplers})


# --- in ----------------------------------------------------------------------------------------------------------


def _rig(glb: Glb, mesh: dict[str, Any], rest: Float[np.ndarray, "4 4"]) -> Rig:
    names = shape_names(glb, mesh)
    surface, source, deltas = _welded(glb, mesh, names, rest)
    neutral, first = surface.mesh(source)
    return Rig(neutral, deltas[:, first] / MM, names, surface.texture)


def source_of_vertices(glb: Glb, node: int | None) -> tuple[Int[np.ndarray, " s"], Float[np.ndarray, "4 4"]]:
    """For each glTF vertex of the face mesh its vertex in `read_rig`'s rig; and mesh -> scene at rest, metres."""
    _, mesh = morph_mesh_node(glb)
    rest = default_matrix(glb, chain_of(glb, node))
    return _welded(glb, mesh, shape_names(glb, mesh), rest)[1], rest


def _welded(
    glb: Glb, mesh: dict[str, Any], names: tuple[str, ...], rest: np.ndarray
) -> tuple[PrimitiveSurface, np.ndarray, np.ndarray]:
    """The mesh's glTF vertices, which of them are one, and their displacements, metres in the scene."""
    parts = mesh["primitives"]
    surface = read_surface(glb, parts, [rest] * len(parts))
    deltas = np.concatenate([shape_deltas(glb, part, names) for part in parts], axis=1) @ rest[:3, :3].T
    source = surface.source
    if source is None:
        source = weld(np.concatenate([surface.vertices, *deltas], axis=1))
    return surface, source, deltas
