"""Heights along the normal as the `displacement` of a UsdPreviewSurface, one map a frame, and back."""

import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float32
from pxr import Sdf, Usd, UsdGeom, UsdShade

from ...errors import BadInput
from ..exr import read_exr, write_exr
from ..gltf.mesh import MM
from .material import asset_bytes, fed_by, texture_reader

NAME = "displacement"
"""Of the folder of maps, `STEM.displacement/`, and of the shader that reads them."""
_CHANNELS = ("R", "G", "B")
"""All the same: programs that take grey pictures for colours find every one."""


def write_maps(folder: Path, heights: Iterable[Float32[np.ndarray, "h w"]]) -> list[str]:
    """Heights, mm, as 16-bit `000000.exr`, ... in a folder that is made; their names. What else it holds stays."""
    folder.mkdir(exist_ok=True)
    names = []
    for t, height in enumerate(heights):
        names.append(f"{t:06d}.exr")
        write_exr(folder / names[-1], dict.fromkeys(_CHANNELS, height), half=True)
    return names


def add_displacement(stage: Usd.Stage, material: Sdf.Path, files: list[str]) -> None:
    """Let the material's surface be displaced by maps (their paths from the file), one at each time code from 0 on.

    The maps hold millimetres, which `scale` turns into the stage's metres; 0 stays 0.
    """
    surface = UsdShade.Shader(stage.GetPrimAtPath(material.AppendChild("surface")))
    image = texture_reader(stage, material, NAME, "raw")
    image.GetInput("file").Set(Sdf.AssetPath(files[0]))  # Blender reads no other
    for t, file in enumerate(files if len(files) > 1 else []):
        image.GetInput("file").Set(Sdf.AssetPath(file), t)
    image.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set((MM, MM, MM, 1.0))
    image.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set((0.0, 0.0, 0.0, 0.0))
    given = surface.CreateInput(NAME, Sdf.ValueTypeNames.Float)
    given.ConnectToSource(image.CreateOutput("r", Sdf.ValueTypeNames.Float))
    shader = UsdShade.Material(stage.GetPrimAtPath(material))
    moved = surface.CreateOutput(NAME, Sdf.ValueTypeNames.Token)
    shader.CreateDisplacementOutput().ConnectToSource(moved)


def is_displaced(mesh: UsdGeom.Mesh) -> bool:
    """Whether a picture displaces the mesh's surface."""
    return fed_by(mesh, NAME) is not None


def read_maps(path: Path, mesh: UsdGeom.Mesh, to_mm: float) -> Iterator[Float32[np.ndarray, "h w"]]:
    """Heights, mm, of every time code that has a map of its own, else of the one map; `to_mm` of one unit of the stage.

    Raises:
        BadInput: a map is missing or no EXR.
    """
    image = fed_by(mesh, NAME)
    file = None if image is None else image.GetInput("file")
    if image is None or not file:
        return
    scale, bias = (_first(image, name, other) for name, other in (("scale", 1.0), ("bias", 0.0)))
    for time in file.GetAttr().GetTimeSamples() or [Usd.TimeCode.Default()]:
        height = _height(path, file.Get(time))
        yield (height * scale + bias) * np.float32(to_mm)


def _first(image: UsdShade.Shader, name: str, other: float) -> np.float32:
    given = image.GetInput(name)
    value = given.Get() if given else None
    return np.float32(other if value is None else value[0])


def _height(path: Path, asset: Sdf.AssetPath) -> Float32[np.ndarray, "h w"]:
    """The first channel of a map beside the file or in its package."""
    data = asset_bytes(asset)
    if data is None:
        raise BadInput(f"{path}: its displacement map {asset.path} is missing; copy it along")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "map.exr"
        copy.write_bytes(data)
        try:
            channels = read_exr(copy)
        except BadInput as error:
            raise BadInput(f"{path}: its displacement map {asset.path} is no EXR; export it again") from error
    return channels.get(_CHANNELS[0], next(iter(channels.values())))
