"""Ways from a capture to the neutral's mesh: closest point, template, and the paper's steps one by one."""

import numpy as np
from jaxtyping import Float

from ..blendshapes.align import AlignedCapture, stabilised
from ..blendshapes.build.artist_mesh import look_up
from ..blendshapes.correspond.dense import SkinWarp, WarpConfig, warp
from ..blendshapes.correspond.matches import MatchConfig
from ..blendshapes.correspond.model_motion import mix_of, motion_image
from ..blendshapes.cylinder_map import mesh_of_map
from ..blendshapes.expression import NeutralFace
from ..faces.bundled import BundledFace
from ..fitting.register_scan import register_scan
from ..image_space.layout import grid_of
from ..mesh import ClosestPoint, mass
from .blendshapes_score import TrueSkin, drift

OURS = "ours"
TEMPLATE = "template fit"
SIZE = 1024
"""Texels a side of the texture that drift is told in."""
UNMATCHED = WarpConfig(matches=MatchConfig(rounds=0))
SIDE_DEG = 60.0
"""Skin farther than this from the front is told apart."""

Points = Float[np.ndarray, "n 3"]


def ways(aligned: AlignedCapture, neutral: NeutralFace, face: BundledFace) -> dict[str, Points]:
    """Positions of the artist's vertices in a capture, NaN where a way gives none."""
    artist = neutral.artist
    pair = aligned.map, aligned.landmarks, neutral.map, neutral.landmarks
    expected = model_motion(aligned, neutral)
    surface = mesh_of_map(aligned.map, 2)
    nearest = ClosestPoint(surface.mesh).query(artist.mesh.vertices).points
    shown = artist.shown[:, None]
    triangles = warp(*pair, config=WarpConfig(flow=None))
    return {
        "closest point": np.where(shown, nearest, np.nan),
        TEMPLATE: np.where(shown, template_fit(aligned, face), np.nan),
        "landmarks and triangles": look_up(artist, aligned.map, triangles),
        "... and flow (paper)": look_up(artist, aligned.map, warp(*pair, config=UNMATCHED)),
        "... and motion": look_up(artist, aligned.map, warp(*pair, expected=expected, config=UNMATCHED)),
        OURS: look_up(artist, aligned.map, warp(*pair, expected=expected)),
    }


def model_motion(aligned: AlignedCapture, neutral: NeutralFace) -> Float[np.ndarray, "h w 2"]:
    """The bundled expressions' flow that the capture's landmarks ask for."""
    mesh = neutral.artist.mesh
    mix = mix_of(neutral.units, mesh, aligned.landmarks, neutral.landmarks)
    return motion_image(mesh, np.tensordot(mix, neutral.units, axes=1), neutral.map.layout)


def template_fit(aligned: AlignedCapture, face: BundledFace) -> Points:
    """The bundled mesh laid on the capture's surface alone, as `mien register` does."""
    fitted = register_scan(mesh_of_map(aligned.map, 2), face)
    return fitted.T_face_scan.inverse().apply(fitted.mesh.vertices)


def warp_of(found: Points, aligned: AlignedCapture, neutral: NeutralFace) -> SkinWarp:
    """The warp under which the artist's vertices come to be where a way put them."""
    mesh, layout = neutral.artist.mesh, neutral.map.layout
    there = np.isfinite(found[:, 0])
    moved = np.where(there[:, None], found - mesh.vertices, 0.0)
    flow = motion_image(mesh, moved, layout)
    return SkinWarp(grid_of(layout.shape) + flow, neutral.map.known & aligned.map.known)


def errors_of(
    found: Points, truth: TrueSkin, weights: Float[np.ndarray, " shapes"], neutral: NeutralFace, face: BundledFace
) -> dict[str, float]:
    """Distances from the true skin, mm, and drift, texels of `SIZE`; the head is held still first."""
    mesh = neutral.artist.mesh
    share = mass(mesh.vertices, mesh.faces) * face.regions["face"]
    still = stabilised(found, mesh.vertices, share).apply(found)
    counted = truth.scored & np.isfinite(still[:, 0])
    off = np.linalg.norm(still - truth.points(weights), axis=1)
    drifted = drift(truth, still, weights, mesh, SIZE)
    angle = np.degrees(np.abs(np.arctan2(mesh.vertices[:, 0], mesh.vertices[:, 2])))
    side = off[counted & (angle > SIDE_DEG)]
    return {
        "mean": float(off[counted].mean()),
        "median": float(np.median(off[counted])),
        "p95": float(np.quantile(off[counted], 0.95)),
        "drift median": float(np.median(drifted[counted])),
        "drift p95": float(np.quantile(drifted[counted], 0.95)),
        "side mean": float(side.mean()) if len(side) else float("nan"),
    }
