"""What of a scan is compared with its neighbours: fine detail of curvature and, where there is some, of colour."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter

from ..mesh import Mesh, SurfaceImage, curvature_features, mean_curvature, vertex_normals
from ..register import Rejection, Surface
from .config import FeatureConfig, FineConfig

NEAR = Rejection(max_distance=3.0)
"""Which points of a scan show what its registered surface is like."""
LUMINANCE = (0.3, 0.6, 0.1)
THIN = 0.05
"""Share of data nearby below which an average means nothing."""


@dataclass(frozen=True)
class Detail:
    """One kind of detail over the layout."""

    scaled: Float[np.ndarray, "h w"]
    """Divided by the rms nearby; 0 where the scan has no data."""
    evidence: Float[np.ndarray, "h w"]
    """0..1: how far the detail stands out of what is faint; 0 where the scan has no data, and fading towards it."""


def detail(raw: Float[np.ndarray, "h w"], kind: FeatureConfig, pixel_mm: float) -> Detail:
    """Detail in an image of raw values, NaN where there is none."""
    known = np.isfinite(raw)
    values = np.where(known, raw, 0.0)
    if np.isfinite(kind.broad_mm):
        values = np.where(known, values - averaged(values, known, kind.broad_mm / pixel_mm), 0.0)
    values = over(values, kind.threshold)
    if np.isfinite(kind.saturation):
        values = kind.saturation * np.tanh(values / kind.saturation)
    energy = averaged(values**2, known, kind.nearby_mm / pixel_mm)
    full = energy + kind.faint**2
    inside = gaussian_filter(known.astype(float), kind.nearby_mm / (2 * pixel_mm))
    evidence = energy / full * np.clip(2 * inside - 1, 0, 1)
    return Detail(values / np.sqrt(full), np.where(known, evidence, 0.0))


def over(image: Float[np.ndarray, "h w"], threshold: float) -> Float[np.ndarray, "h w"]:
    """Values of either sign below the threshold set to 0; NaN stays."""
    return curvature_features(image.ravel(), threshold).reshape(image.shape)


def averaged(values: Float[np.ndarray, "h w"], known: Bool[np.ndarray, "h w"], sigma: float) -> np.ndarray:
    """Gaussian average of the known pixels, sigma in pixels."""
    share = gaussian_filter(known.astype(float), sigma)
    return gaussian_filter(np.where(known, values, 0.0), sigma) / np.maximum(share, THIN)


def raw_images(
    mesh: Mesh, image: SurfaceImage, surface: Surface | None, config: FineConfig
) -> tuple[Float[np.ndarray, "h w"], Float[np.ndarray, "h w"] | None]:
    """Mean curvature, 1/mm, and luminance, 0..1, or None; NaN where there is no data.

    Both of the scan that `mesh` was registered to, at the points closest to what the pixels show, since the mesh is
    smoother than the scan; without a scan the curvature of the mesh.
    """
    radius = config.curvature_radius_mm
    if surface is None:
        return image.draw(mean_curvature(mesh, radius)), None
    values = [mean_curvature(surface.mesh, radius)]
    if surface.mesh.colors is not None and config.colour is not None:
        values.append(surface.mesh.colors @ np.array(LUMINANCE))
    places, normals = image.draw(mesh.vertices), image.draw(vertex_normals(mesh.vertices, mesh.faces))
    found = surface.correspond(places[image.mask], normals[image.mask], NEAR)
    drawn = found.attachment().matrix(surface.mesh) @ np.stack(values, 1)
    out = np.full((len(values), *image.mask.shape), np.nan)
    out[:, image.mask] = np.where(found.accepted[:, None], drawn, np.nan).T
    return out[0], out[1] if len(out) > 1 else None
