"""glTF's node tree: which node bears the face, what stands above it, where that puts it at rest."""

import re
from typing import Any

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from ...transforms import rotations_from_quaternions
from .glb import Glb
from .mesh import vertex_count

_BEARS = 0.1
"""A joint with this share of what the shapes move bears the face; the neck, at the chin's rim, has less."""


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


def default_matrix(glb: Glb, chain: list[int]) -> Float[np.ndarray, "4 4"]:
    """Mesh -> scene, metres, with no animation."""
    whole = np.eye(4)
    for n in chain:
        node = glb.json["nodes"][n]
        if "skin" in node:
            return _skin_matrix(glb, n)
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
            matrix = default_matrix(glb, chain_of(glb, n))
            parts = glb.json["meshes"][node["mesh"]]["primitives"]
            found += [(part, matrix) for part in parts if part.get("mode", 4) == 4]
    return found


def global_matrix(glb: Glb, n: int) -> Float[np.ndarray, "4 4"]:
    """A node -> scene, metres, at rest, skinned or not."""
    parent = {child: m for m, each in enumerate(glb.json["nodes"]) for child in each.get("children", [])}
    whole, seen = node_matrices(glb.json["nodes"][n], {}, 1)[0], {n}
    while n in parent and parent[n] not in seen:
        n = parent[n]
        seen.add(n)
        whole = node_matrices(glb.json["nodes"][n], {}, 1)[0] @ whole
    return whole


def head_joint(glb: Glb, face: int | None) -> int | None:
    """The bone that turns the head: what VRM calls so, else the joint of the face's skin that is named head, else neck,
    else (in another language) the one that bears the face.

    A face without a skin is turned by the bone that it hangs from, if that is named so. None where there is no bone.
    """
    nodes = glb.json.get("nodes", [])
    if face is None or not glb.json.get("skins"):
        return None
    skin = nodes[face].get("skin")
    if skin is None:
        joints = {joint for each in glb.json["skins"] for joint in each["joints"]}
        allowed = [n for n in chain_of(glb, face) if n in joints]
    else:
        allowed = glb.json["skins"][skin]["joints"]
    told = _vrm_head(glb)
    if told is not None and told in allowed:
        return told
    for wanted in ("head", "neck"):
        named = [n for n in allowed if _last_word(nodes[n].get("name") or "") == wanted]
        if named:
            return named[0]
    return None if skin is None else _bearing_joint(glb, face, allowed)


def _bearing_joint(glb: Glb, face: int, joints: list[int]) -> int | None:
    """The joint from which all hang that bear a good part of what the shapes move: a head, with jaw and eyes below."""
    total = np.zeros(len(joints))
    for part in glb.json["meshes"][glb.json["nodes"][face]["mesh"]].get("primitives", []):
        given = part.get("attributes", {})
        shifts = [np.abs(glb.accessor(target["POSITION"])).sum(1) for target in part.get("targets", [])]
        for name in sorted(each for each in given if each.startswith("JOINTS_")):
            share = glb.accessor(given[name.replace("JOINTS", "WEIGHTS")]) * np.sum(shifts, axis=0)[:, None]
            np.add.at(total, glb.accessor(given[name]).astype(int), share)
    bearing = np.flatnonzero(total >= _BEARS * total.sum()) if total.any() else []
    parent = {child: n for n, each in enumerate(glb.json["nodes"]) for child in each.get("children", [])}
    above = [_ancestors(joints[k], parent) for k in bearing]
    common = [n for n in above[0] if all(n in others for others in above)] if above else []
    return next((n for n in common if n in joints), None)


def _ancestors(node: int, parent: dict[int, int]) -> list[int]:
    """A node and those above it, upwards."""
    chain = [node]
    while chain[-1] in parent and parent[chain[-1]] not in chain:
        chain.append(parent[chain[-1]])
    return chain


def _vrm_head(glb: Glb) -> int | None:
    extensions = glb.json.get("extensions") or {}
    bones = ((extensions.get("VRMC_vrm") or {}).get("humanoid") or {}).get("humanBones") or {}
    if isinstance(bones, dict) and "head" in bones:
        return bones["head"]["node"]
    old = ((extensions.get("VRM") or {}).get("humanoid") or {}).get("humanBones") or []
    return next((bone["node"] for bone in old if bone.get("bone") == "head"), None)


def _last_word(name: str) -> str:
    """The last word of a bone's name, numbers aside: `mixamorig:Head`, `CC_Base_Head`, `J_Bip_C_Head` say head."""
    words: list[str] = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)
    return words[-1].lower() if words else ""


def _skin_matrix(glb: Glb, n: int) -> Float[np.ndarray, "4 4"]:
    """Mesh -> scene of a skinned mesh in its bind pose, by the bone of the head or else the first."""
    skin = glb.json["skins"][glb.json["nodes"][n]["skin"]]
    joint = head_joint(glb, n)
    joint = skin["joints"][0] if joint is None else joint
    if "inverseBindMatrices" not in skin:
        return global_matrix(glb, joint)
    binds = glb.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    return global_matrix(glb, joint) @ binds[skin["joints"].index(joint)]
