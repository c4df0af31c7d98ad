"""A rig's colour as a UsdPreviewSurface, and back."""

import io
from pathlib import Path

import numpy as np
from jaxtyping import UInt8
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from ..gltf.mesh import SKIN_LINEAR, SKIN_ROUGHNESS, linear_from_srgb, srgb_from_linear


def add_material(stage: Usd.Stage, mesh: UsdGeom.Mesh, path: Sdf.Path, texture: str | None) -> None:
    """Bind a material to the mesh: a texture (its path from the file), else vertex colours, else one colour."""
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, path.AppendChild("surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(SKIN_ROUGHNESS)
    surface.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    color = surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
    if texture is not None:
        image = texture_reader(stage, path, "base_color", "sRGB")
        image.GetInput("file").Set(Sdf.AssetPath(texture))
        color.ConnectToSource(image.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))
    elif mesh.GetDisplayColorPrimvar().HasAuthoredValue():
        color.ConnectToSource(_vertex_colored(stage, path))
    else:
        color.Set(Gf.Vec3f(*SKIN_LINEAR))
    surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def texture_reader(stage: Usd.Stage, path: Sdf.Path, name: str, color_space: str) -> UsdShade.Shader:
    """A picture laid by the mesh's `st` under a material, its `file` still to be set."""
    places = UsdShade.Shader.Define(stage, path.AppendChild("st"))
    places.CreateIdAttr("UsdPrimvarReader_float2")
    places.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    image = UsdShade.Shader.Define(stage, path.AppendChild(name))
    image.CreateIdAttr("UsdUVTexture")
    image.CreateInput("file", Sdf.ValueTypeNames.Asset)
    image.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(color_space)
    for axis in ("wrapS", "wrapT"):
        image.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("clamp")
    st = places.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    image.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(st)
    return image


def _vertex_colored(stage: Usd.Stage, path: Sdf.Path) -> UsdShade.Output:
    reader = UsdShade.Shader.Define(stage, path.AppendChild("vertex_color"))
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    return reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)


def linear_colors(colors: np.ndarray) -> np.ndarray:
    """sRGB vertex colours as `displayColor` wants them."""
    return linear_from_srgb(colors).astype(np.float32)


def srgb_colors(mesh: UsdGeom.Mesh, count: int) -> np.ndarray | None:
    """A mesh's `displayColor` as sRGB, one a vertex; None where it has none or has them otherwise."""
    colors = mesh.GetDisplayColorPrimvar()
    values = colors.ComputeFlattened() if colors.HasAuthoredValue() else None
    if values is None or colors.GetInterpolation() not in ("vertex", "varying") or len(values) != count:
        return None
    return srgb_from_linear(np.clip(np.array(values, np.float64), 0, 1))


def read_texture(mesh: UsdGeom.Mesh) -> UInt8[np.ndarray, "h w 3"] | None:
    """The picture that feeds the diffuse colour of the mesh's material; None where there is none that can be read."""
    image = fed_by(mesh, "diffuseColor")
    file = None if image is None else image.GetInput("file")
    data = asset_bytes(file.Get()) if file and file.Get() else None
    if data is None:
        return None
    try:
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
    except OSError:
        return None


def fed_by(mesh: UsdGeom.Mesh, name: str) -> UsdShade.Shader | None:
    """What feeds an input of the surface of the mesh's material; None where nothing does."""
    material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()
    surface = material.ComputeSurfaceSource()[0] if material else None
    given = surface.GetInput(name) if surface else None
    sources = given.GetConnectedSources()[0] if given else None
    return UsdShade.Shader(sources[0].source.GetPrim()) if sources else None


def asset_bytes(asset: Sdf.AssetPath) -> bytes | None:
    """An asset's content, from beside the file or from inside a package."""
    from pxr import Ar

    resolved = asset.resolvedPath
    if not resolved:
        return None
    if Path(resolved).is_file():
        return Path(resolved).read_bytes()
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
    return None if opened is None else bytes(opened.GetBuffer())
