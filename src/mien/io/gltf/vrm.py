"""VRM avatars: which morph targets their expressions stand for (VRM 0.x and 1.0)."""

from collections.abc import Sequence
from pathlib import Path

from ...rig.shape_names import match_names
from .glb import Glb, damage_told, open_glb
from .shapes import shape_names

_PRESETS = {"a": "aa", "i": "ih", "u": "ou", "e": "ee", "o": "oh"}
"""VRM 0.x's vowels by the names of VRM 1.0."""


def expression_pairs(path: str | Path, sources: Sequence[str]) -> dict[str, str]:
    """{morph target: source} for targets whose own name says nothing, but whose VRM expression does.

    An expression counts that moves one target of a mesh alone. Files that are no VRM give none.
    """
    glb = open_glb(path)
    with damage_told(glb.path):
        pairs: dict[str, str] = {}
        for mesh_index, named in _by_mesh(glb).items():
            mesh = glb.json["meshes"][mesh_index]
            names = shape_names(glb, mesh)
            direct = match_names(sources, names)
            expressed = match_names(sources, list(named))
            for k, expression in enumerate(named):
                source = next((s for s, row in zip(sources, expressed.share, strict=True) if row[k]), None)
                if source in direct.missing and not direct.share[:, named[expression]].any():
                    pairs[names[named[expression]]] = source
    return pairs


def _by_mesh(glb: Glb) -> dict[int, dict[str, int]]:
    """For each mesh {expression: the one target that it moves there}."""
    extensions = glb.json.get("extensions") or {}
    found: dict[int, dict[str, int]] = {}
    for name, binds in [*_old(extensions.get("VRM") or {}), *_new(glb, extensions.get("VRMC_vrm") or {})]:
        for mesh in {mesh for mesh, _ in binds}:
            targets = [target for bound, target in binds if bound == mesh]
            if len(targets) == 1:
                found.setdefault(mesh, {})[name] = targets[0]
    return found


def _old(vrm: dict) -> list[tuple[str, list[tuple[int, int]]]]:
    groups = (vrm.get("blendShapeMaster") or {}).get("blendShapeGroups") or []
    out = []
    for group in groups:
        preset = group.get("presetName") or "unknown"
        name = group.get("name", "") if preset == "unknown" else _PRESETS.get(preset, preset)
        out.append((name, [(bind["mesh"], bind["index"]) for bind in group.get("binds") or []]))
    return out


def _new(glb: Glb, vrm: dict) -> list[tuple[str, list[tuple[int, int]]]]:
    expressions = vrm.get("expressions") or {}
    named = {**(expressions.get("custom") or {}), **(expressions.get("preset") or {})}
    out = []
    for name, expression in named.items():
        binds = expression.get("morphTargetBinds") or []
        out.append((name, [(glb.json["nodes"][bind["node"]]["mesh"], bind["index"]) for bind in binds]))
    return out
