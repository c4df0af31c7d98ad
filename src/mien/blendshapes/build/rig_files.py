"""A textured rig on disk: NAME.glb (or .usd), a folder of PNGs, and NAME.rig.json that says which is which."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import BadInput
from ...files import existing, whole
from ...io.meshes.images import read_image, write_image
from ...io.rigs import read_any_rig, write_any_rig
from .masks import TexturedRig

VERSION = 1


def record_of(rig: str | Path) -> Path:
    """Where what is known of a rig's textures is kept."""
    return Path(rig).with_suffix(".rig.json")


def write_textured_rig(path: str | Path, textured: TexturedRig, notes: dict[str, Any] | None = None) -> None:
    """Write the rig, each capture's texture, each region's mask, and the record.

    Raises:
        BadInput: the folder does not exist.
    """
    path = Path(path)
    folder = path.with_suffix(".textures")
    write_any_rig(path, textured.rig)
    folder.mkdir(exist_ok=True)
    captures = {}
    for k, name in enumerate(textured.captures):
        file = folder / f"{name}.png"
        write_image(file, textured.textures[k])
        mix = textured.mixes[k]
        shares = {textured.rig.names[i]: round(float(mix[i]), 5) for i in np.flatnonzero(mix > 1e-4)}
        captures[name] = {"texture": f"{folder.name}/{file.name}", "regions": textured.regions[k], "mix": shares}
    masks = {}
    for name, mask in textured.mask_textures.items():
        file = folder / f"mask_{name}.png"
        write_image(file, np.repeat((mask * 255).round().astype(np.uint8)[..., None], 3, axis=2))
        masks[name] = f"{folder.name}/{file.name}"
    record = {"version": VERSION, "captures": captures, "masks": masks, **(notes or {})}
    with whole(record_of(path)) as temporary:
        temporary.write_text(json.dumps(record, indent=1) + "\n")


def read_textured_rig(path: str | Path) -> TexturedRig | None:
    """A rig with its textures; None where no record lies beside it.

    Raises:
        BadInput: the record or a picture is missing or damaged, or belongs to another rig.
    """
    record = record_of(path)
    if not record.is_file():
        return None
    rig = read_any_rig(path)
    try:
        told = json.loads(record.read_text())
        captures = told["captures"]
        names = tuple(captures)
        mixes = np.array([[captures[c]["mix"].get(name, 0.0) for name in rig.names] for c in names], float)
        regions = tuple(tuple(captures[c]["regions"]) for c in names)
        files = [existing(record.parent / captures[c]["texture"]) for c in names]
        masks = {name: read_image(existing(record.parent / f))[..., 0] / 255.0 for name, f in told["masks"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{record}: not a record of textures ({error}); make it anew with `mien rig`") from None
    textures = [read_image(file) for file in files]
    shapes = {image.shape for image in textures} | ({rig.texture.shape} if rig.texture is not None else set())
    if rig.texture is None or len(shapes) != 1:
        raise BadInput(f"{record}: its textures are of several sizes, or the rig has none; make it with `mien rig`")
    return TexturedRig(rig, np.stack(textures) if textures else np.zeros((0, *rig.texture.shape), np.uint8), names,
                       regions, masks, mixes.reshape(len(names), len(rig.names)))  # fmt: skip
