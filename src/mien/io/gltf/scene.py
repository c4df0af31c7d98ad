"""glTF's node tree: which node bears the face, what stands above it, where that puts it at rest."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...transforms import rotations_from_quaternions
from .glb import Glb
from .mesh import vertex_count


def morph_mesh_node(glb: Glb) -> tuple[int | None, dict[str, Any]]:
    """The node of the mesh with the most morph targets, then vertices (None: in no node), and that mesh.

    Raises:
        BadInput: no mesh has morph targets.
    """
    meshes = glb.json.get("meshes", [])
    morphed = [i for i, mesh in enumerate(meshes) if all(part.get("targets") for part in mesh["primitives"])]
    if not morphed:
        raise BadInput(f"{glb.path}: has no morph targets, so it is no rig; export shape keys (blend shapes) along")
    best = max(morphed, key=lambda i: _size(glb, meshes[i]))
    nodes = [n for n, node in enumerate(glb.json.get("nodes", [])) if node.get("mesh") == best]
    return (nodes[0] if nodes else None), meshes[best]


def chain_of(glb: Glb, node: int | None) -> list[int]:
    """Nodes from the scene's root down to `node`. A skinned mesh stands where its skin says: no node moves it."""
    if node is None or "skin" in glb.json["nodes"][node]:
        return [] if node is None else [node]
    parent = {child: n for n, each in enumerate(glb.json["nodes"]) for child in each.get("children", [])}
    chain = [node]
    while chain[0] in parent:
        if parent[chain[0]] in chain:
            raise BadInput(f"{glb.path}: is damaged: a node is its own ancestor")
        chain.insert(0, parent[chain[0]])
    return chain


def rest_matrix(glb: Glb, chain: list[int]) -> Float[np.ndarray, "4 4"]:
    """Mesh -> scene, metres, with no animation."""
    whole = np.eye(4)
    for n in chain:
        node = glb.json["nodes"][n]
        if "skin" in node:
            return np.eye(4)
        whole = whole @ node_matrices(node, {}, 1)[0]
    return whole


def node_matrices(
    node: dict[str, Any], animated: dict[str, np.ndarray], frames: int
) -> Float[np.ndarray, "frames 4 4"]:
    """A node's own transform, frame by frame; what `animated` has (translation, rotation, scale) replaces its own."""
    if "matrix" in node and not animated:
        return np.tile(np.reshape(node["matrix"], (4, 4)).T.astype(np.float64), (frames, 1, 1))
    defaults = {"translation": [0.0, 0, 0], "rotation": [0.0, 0, 0, 1], "scale": [1.0, 1, 1]}
    t, q, s = (
        animated[key] if key in animated else np.tile(np.asarray(node.get(key, default), np.float64), (frames, 1))
        for key, default in defaults.items()
    )
    out = np.tile(np.eye(4), (frames, 1, 1))
    out[:, :3, :3] = rotations_from_quaternions(q) * s[:, None, :]
    out[:, :3, 3] = t
    return out


def _size(glb: Glb, mesh: dict[str, Any]) -> tuple[int, int]:
    parts = mesh["primitives"]
    return len(parts[0]["targets"]), sum(vertex_count(glb, part) for part in parts)


def drawn_parts(glb: Glb) -> list[tuple[dict[str, Any], Float[np.ndarray, "4 4"]]]:
    """Every primitive made of triangles that a node shows, with its matrix to the scene, in metres."""
    found = []
    for n, node in enumerate(glb.json.get("nodes", [])):
        if "mesh" in node:
            matrix = rest_matrix(glb, chain_of(glb, n))
            parts = glb.json["meshes"][node["mesh"]]["primitives"]
            found += [(part, matrix) for part in parts if part.get("mode", 4) == 4]
    return found
