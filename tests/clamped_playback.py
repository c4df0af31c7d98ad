"""A glTF performance as viewers play it that clamp morph weights."""

import numpy as np

from mien.io.gltf.glb import open_glb


def played_with_clamping(path) -> np.ndarray:
    """Vertices frame by frame as Blender shows the file: every weight clamped to 0..1, read by the accessors alone."""
    glb = open_glb(path)
    part = glb.json["meshes"][0]["primitives"][0]
    rest = glb.accessor(part["attributes"]["POSITION"])
    targets = np.stack([glb.accessor(t["POSITION"]) for t in part["targets"]])
    animation = glb.json["animations"][0]
    channel = next(c for c in animation["channels"] if c["target"]["path"] == "weights")
    weights = glb.accessor(animation["samplers"][channel["sampler"]]["output"]).reshape(-1, len(targets))
    return (rest + np.tensordot(np.clip(weights, 0, 1), targets, 1)) * 1000
