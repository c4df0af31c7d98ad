"""A performance played on a file of somebody else: all that it holds stays, every mesh with the names is animated."""

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from ...files import note_clock
from ...rig import Performance
from ...rig.shape_names import match_names
from ...rig.unit_weights import CORRECTIVE, with_unit_weights
from ...transforms import quaternions_from_rotations, rotations_from_quaternions
from . import source_of_vertices
from .glb import Glb, GlbBuilder, damage_told, open_glb
from .mesh import MM, vertex_count
from .scene import global_matrix, head_joint, morph_mesh_node
from .shapes import shape_names

_ABOUT = 0.25
"""A mesh belongs to the head whose middle lies in the face mesh's box, grown by this share of its size."""
OURS = "mien"
"""The generator that our own files name."""


def is_ours(path: str | Path) -> bool:
    """Whether a file was written by `write_rig` or `write_performance`, and so holds nothing but a rig."""
    return open_glb(path).json.get("asset", {}).get("generator") == OURS


def write_on_avatar(
    source: str | Path,
    output: str | Path,
    played: Performance,
    performed: Performance,
    given: Mapping[str, str] | None = None,
) -> list[str]:
    """Write `source` with an animation more, as `.glb`; gives lines on what was animated.

    Args:
        source: `.glb`, `.gltf` or `.vrm`.
        played: the performance on the file's own rig (`rig.retarget`), poses as motions of its scene.
        performed: the same before it was retargeted, by whose names the other meshes are driven.
        given: pairs of names by hand.

    Raises:
        BadInput: as `open_glb`, or no folder for `output`.
    """
    glb = open_glb(source)
    with damage_told(glb.path):
        build = GlbBuilder(copy.deepcopy(glb.json), bytearray(glb.blob))
        node, mesh = morph_mesh_node(glb)
        unit = with_unit_weights(played)
        names = shape_names(glb, mesh)
        extra = [k for k, name in enumerate(unit.rig.names) if name not in names]
        face = build.json["meshes"][glb.json["meshes"].index(mesh)]
        _add_targets(build, glb, node, face, unit, extra)
        clock = build.accessor((np.arange(len(unit)) / unit.rate).astype(np.float32), bounds=True)
        tracks = _Tracks(build, clock)
        column = {name: k for k, name in enumerate(unit.rig.names)}
        order = [column[name] for name in [*names, *(unit.rig.names[k] for k in extra)]]
        driven = _drive(tracks, glb, glb.json["meshes"].index(mesh), unit.weights[:, order], performed, given)
        moved = _move_head(tracks, glb, node, unit)
        marked = node if node is not None else 0
        extras = build.json["nodes"][marked].get("extras") or {}
        untracked = np.flatnonzero(~unit.tracked).tolist()
        build.json["nodes"][marked]["extras"] = {**extras, "rate": unit.rate, "untracked": untracked}
        build.json.setdefault("animations", []).insert(0, tracks.animation)
    build.save(output)
    note_clock(output, unit.rate, len(unit))
    return [f"animated {', '.join(driven)}; {moved}"]


class _Tracks:
    """Channels of one animation."""

    def __init__(self, build: GlbBuilder, clock: int):
        self.build, self._clock = build, clock
        self.animation: dict[str, Any] = {"name": "performance", "channels": [], "samplers": []}

    def add(self, node: int, path: str, values: np.ndarray) -> None:
        """One value a frame for a node's translation, rotation or weights."""
        output = self.build.accessor(np.ascontiguousarray(values, dtype=np.float32))
        sampler = {"input": self._clock, "output": output, "interpolation": "LINEAR"}
        target = {"sampler": len(self.animation["samplers"]), "target": {"node": node, "path": path}}
        self.animation["samplers"].append(sampler)
        self.animation["channels"].append(target)


def _drive(
    tracks: _Tracks, glb: Glb, face: int, weights: np.ndarray, performed: Performance, given: Mapping[str, str] | None
) -> list[str]:
    """Weights for every node whose mesh has shapes of these names; gives what was driven."""
    driven = []
    own = [k for k, name in enumerate(performed.rig.names) if not name.startswith(CORRECTIVE)]
    sources = [performed.rig.names[k] for k in own]
    for n, node in enumerate(glb.json.get("nodes", [])):
        if "mesh" not in node or not all(
            part.get("targets") for part in glb.json["meshes"][node["mesh"]]["primitives"]
        ):
            continue
        mesh = glb.json["meshes"][node["mesh"]]
        name = node.get("name") or mesh.get("name") or f"node {n}"
        values = weights
        if node["mesh"] != face:
            match = match_names(sources, shape_names(glb, mesh), given)
            values = np.clip(match.weights(performed.weights[:, own]), 0.0, 1.0)
            if not match.moved:
                continue
        tracks.add(n, "weights", values.ravel())
        driven.append(name)
    return driven


def _add_targets(
    build: GlbBuilder, glb: Glb, node: int | None, face: dict[str, Any], unit: Performance, extra: list[int]
) -> None:
    """Shapes that the file did not have, behind its own."""
    if not extra:
        return
    names = list(shape_names(glb, face))
    source, rest = source_of_vertices(glb, node)
    inverse = np.linalg.inv(rest[:3, :3])
    start = 0
    for part in face["primitives"]:
        count = vertex_count(glb, part)
        rows = source[start : start + count]
        for k in extra:
            shift = (unit.rig.deltas[k][rows] * MM @ inverse.T).astype(np.float32)
            part["targets"].append({"POSITION": build.sparse_accessor(shift, name=unit.rig.names[k])})
        start += count
    extras = face.get("extras") or {}
    face["extras"] = {**extras, "targetNames": [*names, *(unit.rig.names[k] for k in extra)]}
    if "weights" in face:
        face["weights"] = [*face["weights"], *([0.0] * len(extra))]
    for each in build.json["nodes"]:
        if "weights" in each and "mesh" in each and build.json["meshes"][each["mesh"]] is face:
            each["weights"] = [*each["weights"], *([0.0] * len(extra))]


def _move_head(tracks: _Tracks, glb: Glb, node: int | None, unit: Performance) -> str:
    """The head's motion: of its bone where there is one, else of the nodes that are the head."""
    joint = head_joint(glb, node)
    if joint is not None:
        _turn_joint(tracks, glb, joint, unit)
        return f"the head turns by its bone {glb.json['nodes'][joint].get('name', joint)}"
    motion = np.tile(np.eye(4), (len(unit), 1, 1))
    motion[:, :3, :3] = unit.T_world_face.rotation
    motion[:, :3, 3] = unit.T_world_face.translation * MM
    heads = _head_nodes(glb, node)
    for parent in dict.fromkeys(parent for _, parent in heads):
        inside = np.eye(4) if parent is None else global_matrix(glb, parent)
        local = np.linalg.inv(inside) @ motion @ inside
        children = [child for child, above in heads if above == parent]
        wrapper = tracks.build.add("nodes", {"name": "head_motion", "children": children})
        nodes = tracks.build.json["nodes"]
        if parent is None:
            scene = tracks.build.json["scenes"][tracks.build.json.get("scene", 0)]
            scene["nodes"] = [wrapper, *(n for n in scene["nodes"] if n not in children)]
        else:
            nodes[parent]["children"] = [wrapper, *(n for n in nodes[parent]["children"] if n not in children)]
        tracks.add(wrapper, "translation", local[:, :3, 3])
        tracks.add(wrapper, "rotation", quaternions_from_rotations(_rotation_of(local[:, :3, :3])))
    return f"the head moves with {len(heads)} of the file's parts"


def _turn_joint(tracks: _Tracks, glb: Glb, joint: int, unit: Performance) -> None:
    """World rotations about the bone's own origin, as rotations of the bone below its parent."""
    parents = {child: n for n, each in enumerate(glb.json["nodes"]) for child in each.get("children", [])}
    above = global_matrix(glb, parents[joint])[:3, :3] if joint in parents else np.eye(3)
    P = _rotation_of(above[None])[0]
    node = tracks.build.json["nodes"][joint]
    if "matrix" in node:
        matrix = np.reshape(node.pop("matrix"), (4, 4)).T.astype(float)
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        node["translation"], node["scale"] = matrix[:3, 3].tolist(), scale.tolist()
        node["rotation"] = quaternions_from_rotations(_rotation_of(matrix[None, :3, :3]))[0].tolist()
    rest = rotations_from_quaternions(np.array([node.get("rotation", [0.0, 0, 0, 1])], dtype=float))[0]
    local = P.T @ unit.T_world_face.rotation @ P @ rest
    tracks.add(joint, "rotation", quaternions_from_rotations(local))


def _rotation_of(matrices: Float[np.ndarray, "frames 3 3"]) -> Float[np.ndarray, "frames 3 3"]:
    u, _, vt = np.linalg.svd(matrices)
    return u @ vt


def _head_nodes(glb: Glb, face: int | None) -> list[tuple[int, int | None]]:
    """The topmost nodes that bear nothing but the head, each with its parent."""
    nodes = glb.json["nodes"]
    roots = glb.json["scenes"][glb.json.get("scene", 0)]["nodes"] if glb.json.get("scenes") else []
    boxes = {n: _box(glb, n) for n, node in enumerate(nodes) if "mesh" in node}
    if face is None or face not in boxes:
        return [(n, None) for n in roots]
    low, high = boxes[face]
    slack = _ABOUT * (high - low)
    middles = {n: box.mean(axis=0) for n, box in boxes.items()}
    in_head = {n: bool(((m >= low - slack) & (m <= high + slack)).all()) for n, m in middles.items()}

    def below(n: int) -> list[int]:
        return [n, *(m for child in nodes[n].get("children", []) for m in below(child))]

    def chosen(n: int, parent: int | None) -> list[tuple[int, int | None]]:
        kinds = [in_head[m] for m in below(n) if m in in_head]
        if not any(kinds):
            return []
        if all(kinds) or in_head.get(n, False):
            return [(n, parent)]
        return [found for child in nodes[n].get("children", []) for found in chosen(child, n)]

    return [found for root in roots for found in chosen(root, None)]


def _box(glb: Glb, node: int) -> Float[np.ndarray, "2 3"]:
    parts = glb.json["meshes"][glb.json["nodes"][node]["mesh"]]["primitives"]
    points = np.concatenate([glb.accessor(part["attributes"]["POSITION"]) for part in parts])
    matrix = global_matrix(glb, node)
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    return np.stack([points.min(axis=0), points.max(axis=0)])
