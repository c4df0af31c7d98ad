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
        color.ConnectToSource(_textured(stage, path, texture))
    elif mesh.GetDisplayColorPrimvar().HasAuthoredValue():
        color.ConnectToSource(_vertex_colored(stage, path))
    else:
        color.Set(Gf.Vec3f(*SKIN_LINEAR))
    surface.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def _textured(stage: Usd.Stage, path: Sdf.Path, texture: str) -> UsdShade.Output:
    reader = UsdShade.Shader.Define(stage, path.AppendChild("st"))
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    image = UsdShade.Shader.Define(stage, path.AppendChild("base_color"))
    image.CreateIdAttr("UsdUVTexture")
    image.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(Sdf.AssetPath(texture))
    image.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("sRGB")
    for axis in ("wrapS", "wrapT"):
        image.CreateInput(axis, Sdf.ValueTypeNames.Token).Set("clamp")
    places = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    image.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(places)
    return image.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)


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
    material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()
    surface = material.ComputeSurfaceSource()[0] if material else None
    source = surface.GetInput("diffuseColor").GetConnectedSources()[0] if surface else None
    if not source:
        return None
    file = UsdShade.Shader(source[0].source.GetPrim()).GetInput("file")
    data = _bytes(file.Get()) if file and file.Get() else None
    if data is None:
        return None
    try:
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
    except OSError:
        return None


def _bytes(asset: Sdf.AssetPath) -> bytes | None:
    """An asset's content, from beside the file or from inside a package."""
    from pxr import Ar

    resolved = asset.resolvedPath
    if not resolved:
        return None
    if Path(resolved).is_file():
        return Path(resolved).read_bytes()
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
    return None if opened is None else bytes(opened.GetBuffer())
