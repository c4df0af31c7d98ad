"""Morph targets of a glTF mesh: their names and displacements."""

from typing import Any

import numpy as np
from jaxtyping import Float

from ...errors import BadInput
from .glb import Glb
from .mesh import vertex_count


def shape_names(glb: Glb, mesh: dict[str, Any]) -> tuple[str, ...]:
    """From `extras.targetNames` of the mesh or its first primitive, else the accessors' names, else `target_000`, ...

    Raises:
        BadInput: no list, fewer or more names than targets, or two alike.
    """
    targets = mesh["primitives"][0]["targets"]
    holders = (mesh, mesh["primitives"][0])
    names = next((n for holder in holders if (n := (holder.get("extras") or {}).get("targetNames"))), None)
    if names is None:
        accessors = [glb.json["accessors"][target["POSITION"]] if "POSITION" in target else {} for target in targets]
        names = [accessor.get("name") or f"target_{i:03d}" for i, accessor in enumerate(accessors)]
    if not isinstance(names, list):
        raise BadInput(f"{glb.path}: its targetNames are no list; export it again")
    names = [str(name) for name in names]
    if len(names) != len(targets):
        raise BadInput(f"{glb.path}: has {len(targets)} morph targets but {len(names)} targetNames; export it again")
    twice = [name for i, name in enumerate(names) if name in names[:i]]
    if twice:
        raise BadInput(f"{glb.path}: two morph targets are named {twice[0]}; give each its own name")
    return tuple(names)


def shape_deltas(glb: Glb, part: dict[str, Any], names: tuple[str, ...]) -> Float[np.ndarray, "shapes n 3"]:
    """Displacements of a primitive's vertices under every target, in its own unit.

    Raises:
        BadInput: not as many targets as names, another vertex count, not finite.
    """
    n = vertex_count(glb, part)
    if len(part["targets"]) != len(names):
        raise BadInput(f"{glb.path}: parts of its mesh have {len(part['targets'])} and {len(names)} morph targets")
    out = np.zeros((len(names), n, 3))
    for k, (name, target) in enumerate(zip(names, part["targets"], strict=True)):
        if "POSITION" not in target:
            continue
        shift = glb.accessor(target["POSITION"])
        if len(shift) != n:
            raise BadInput(f"{glb.path}: morph target {name} has {len(shift)} vertices, the neutral {n}; export again")
        if not np.isfinite(shift).all():
            raise BadInput(f"{glb.path}: morph target {name} is not finite; export again")
        out[k] = shift
    return out
