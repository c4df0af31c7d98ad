"""The mesh whose topology all expressions get, and how it takes their shape (Casas et al. 2016, sec. 5.1)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float
from scipy.optimize import lsq_linear
from scipy.sparse.linalg import splu

from ...faces.arkit import ARKIT_NAMES
from ...faces.bundled import BundledFace
from ...fitting.register_scan import register_scan
from ...fitting.template_parts import TemplateParts
from ...image_space.layout import sampled
from ...landmarks.lift import Landmarks3D
from ...mesh import Mesh, cotangent_laplacian, mass, submesh
from ...transforms import Transform
from ..correspond.dense import SkinWarp
from ..correspond.landmarks import MapLandmarks
from ..cylinder_map import CylinderMap, mesh_of_map

ON_MAP_MM = 1.5
"""A vertex farther than this from the map's point at its pixel is hidden behind it."""
SURE = 0.05
"""Least confidence of a point that is looked up."""
STEADY = 0.3
"""Weight of no motion beside the captured points, when bundled expressions are mixed for what no scan shows."""
SURFACE_MM = 1.0
"""The neutral scan is registered at so many millimetres a pixel."""


@dataclass(frozen=True)
class ArtistMesh:
    """The neutral in the topology of the rig."""

    mesh: Mesh
    """Face space, mm."""
    pixels: Float[np.ndarray, "n 2"]
    """Where each vertex is in the neutral's map."""
    shown: Bool[np.ndarray, " n"]
    """Vertices on the map's surface; the others are hidden (mouth, eyes, back of the head)."""
    offsets: Float[np.ndarray, "n 3"]
    """From the map's point to the vertex, mm; 0 where hidden."""


def bundled_mesh(neutral: CylinderMap, landmarks: MapLandmarks, face: BundledFace) -> ArtistMesh:
    """The bundled topology on the neutral scan: it gives the whole head, eyes and teeth.

    Raises:
        BadInput: the scan cannot be registered.
    """
    surface = mesh_of_map(neutral, max(1, round(SURFACE_MM / neutral.layout.pixel_mm)))
    calm = dict.fromkeys(ARKIT_NAMES, 0.0)
    points = np.where(landmarks.known[:, None], landmarks.points, np.nan)
    deviation = np.where(landmarks.known, 0.5, np.nan)
    found = register_scan(
        surface, face, Landmarks3D(points, deviation, Transform.identity(), "mm", calm, 0.0, False)
    )
    back = found.T_face_scan.inverse()
    placed = found.mesh.with_vertices(back.apply(found.mesh.vertices))
    return on_map(placed, neutral, face.on_skin & (TemplateParts(face).trust > 0))


def on_map(mesh: Mesh, neutral: CylinderMap, skin: Bool[np.ndarray, " n"] | None = None) -> ArtistMesh:
    """Any mesh that lies on the neutral scan, in face space.

    skin: vertices that a scan can show at all.
    """
    pixels = neutral.layout.pixels(mesh.vertices)
    points, _ = neutral.at(pixels)
    sure = sampled(neutral.confidence.astype(float), pixels)[:, 0] > SURE
    off = np.linalg.norm(points - mesh.vertices, axis=1)
    shown = sure & (np.nan_to_num(off, nan=np.inf) < ON_MAP_MM)
    if skin is not None:
        shown &= skin
    return ArtistMesh(mesh, pixels, shown, np.where(shown[:, None], mesh.vertices - np.nan_to_num(points), 0.0))


def look_up(artist: ArtistMesh, source: CylinderMap, warp: SkinWarp) -> Float[np.ndarray, "n 3"]:
    """The vertices' positions in an expression: the warped map at their pixels, mm; NaN where it does not show them."""
    places = sampled(warp.pixels, artist.pixels)
    seen = sampled(warp.shown.astype(float), artist.pixels)[:, 0] > 0.5
    points, _ = source.at(places)
    sure = sampled(source.confidence.astype(float), places)[:, 0] > SURE
    keep = artist.shown & seen & sure & np.isfinite(points[:, 0])
    return np.where(keep[:, None], points + artist.offsets, np.nan)


def complete(
    artist: ArtistMesh,
    found: Float[np.ndarray, "n 3"],
    face: BundledFace,
    units: Float[np.ndarray, "shapes n 3"],
    edges: Float[np.ndarray, "n 3"] | None = None,
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, " shapes"]]:
    """All vertices of an expression of the bundled topology, and the bundled expressions' share in it.

    What no scan shows follows a mix of the bundled expressions (`units`, on this neutral) that fits what it does show;
    on the skin the misfit of the seen is carried on smoothly. Returns displacements, mm, and weights in 0..1.

    edges: displacements of lids and lips along their edges, NaN elsewhere, for those that were not found.
    """
    if edges is not None:
        found = np.where(np.isnan(found), artist.mesh.vertices + edges, found)
    known = np.isfinite(found[:, 0])
    moved = np.where(known[:, None], found - artist.mesh.vertices, 0.0)
    rows = units[:, known].reshape(len(units), -1).T
    damped = np.concatenate([rows, STEADY * np.sqrt(known.sum()) * np.eye(len(units))])
    wanted = np.concatenate([moved[known].ravel(), np.zeros(len(units))])
    weights = np.asarray(lsq_linear(damped, wanted, (0, 1)).x)
    model = np.tensordot(weights, units, axes=1)
    misfit = np.where(known[:, None], moved - model, 0.0)
    skin, members = submesh(artist.mesh, face.skin_faces)
    carried = np.zeros_like(model)
    carried[members] = carry_on(skin, misfit[members], known[members])
    return model + carried, weights


def carry_on(
    mesh: Mesh, values: Float[np.ndarray, "n 3"], known: Bool[np.ndarray, " n"], reach_mm: float = 40.0
) -> Float[np.ndarray, "n 3"]:
    """Values of known vertices carried on over the others, never beyond theirs, fading out over `reach_mm`.

    The least slope, not the least bending: that goes on as it began, and turns the inside of an open mouth out.
    """
    free = np.flatnonzero(~known)
    if not len(free) or not known.any():
        return values
    area = mass(mesh.vertices, mesh.faces)
    area = np.maximum(area, 1e-3 * area.mean())
    L = cotangent_laplacian(mesh.vertices, mesh.faces)
    B = sp.csc_matrix(L + sp.diags(area / reach_mm**2))
    held = np.flatnonzero(known)
    factor = splu(sp.csc_matrix(B[free][:, free]), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    out = values.copy()
    out[free] = factor.solve(-(B[free][:, held] @ values[held]))
    return out
