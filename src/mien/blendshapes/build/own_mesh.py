"""A rig's mesh that is not the bundled one: the neutral thinned by itself, or any that lies on it (sec. 5.1)."""

from dataclasses import dataclass, replace

import igl
import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float, Int

from ...errors import BadInput
from ...landmarks.detector import LOOPS
from ...mesh import Attachment, Mesh, adjacency, closest_point, in_largest_part, submesh
from ...transforms import Transform
from ..correspond.dense import SkinWarp
from ..correspond.landmarks import MapLandmarks
from ..cylinder_map import CylinderLayout, CylinderMap, mesh_of_map, with_corner_uv
from ..scan.fuse import largest_piece
from .artist_mesh import SURE, ArtistMesh, carry_on, look_up, on_map

SURFACE_MM = 1.0
"""The neutral is thinned from a surface of so many millimetres a pixel."""
CENTRES = {"lips_outer": 30.0, "eye_left": 24.0, "eye_right": 24.0}
"""Landmarks whose middle is a centre of the magnified parts, and the part's radius, mm."""
MAGNIFIED = 1.9
"""Times that the middle of a part is larger: triangles of one size there are so much smaller on the face. Above 3.2 it
folds over; at 2.5 triangles round it become needles."""
LIPS_MM = 6.0
"""The cut between the lips does not reach farther above and below their line."""
LEAST_SHOWN = 0.2
"""Of a mesh that is given at least this share of the vertices lies on the neutral scan."""


@dataclass(frozen=True)
class OwnMesh:
    """What a rig is made on instead of the bundled topology."""

    artist: ArtistMesh
    onto: sp.csr_matrix
    """(n, bundled n): values of the nearest bundled skin."""

    def of_bundled(self, values: Float[np.ndarray, "bundled *c"]) -> Float[np.ndarray, "n *c"]:
        """Values of the bundled mesh's vertices on this one."""
        flat = self.onto @ values.reshape(len(values), -1)
        return flat.reshape(-1, *values.shape[1:])


def thinned(neutral: CylinderMap, landmarks: MapLandmarks, triangles: int) -> Mesh:
    """The neutral's surface of so many triangles, small ones at mouth and eyes, with the cylinder's uv.

    Edges are collapsed, the shortest first, on a surface that is magnified there. Cut along the lips: they can part.
    """
    sure = largest_piece(neutral.known & (neutral.confidence > SURE))
    cut = replace(neutral, positions=np.where(sure[..., None], neutral.positions, np.float32(np.nan)))
    surface = parted(mesh_of_map(cut, max(1, round(SURFACE_MM / neutral.layout.pixel_mm))).mesh, landmarks)
    large = magnified(surface.vertices, landmarks)
    points, pieces, _ = igl.split_nonmanifold(large, surface.faces)
    moved, faces, _, _ = igl.decimate(np.asfortranarray(points), np.asfortranarray(pieces, np.int32), triangles)
    back = closest_point(Mesh(large, surface.faces), np.asarray(moved)).attachment()
    mesh = Mesh(back.points(surface), np.asarray(faces, np.int64))
    mesh, _ = submesh(mesh, in_largest_part(mesh.faces, len(mesh.vertices)))
    return replace(mesh, uv=cylinder_uv(mesh.vertices, neutral.layout))


def parted(mesh: Mesh, landmarks: MapLandmarks) -> Mesh:
    """The surface cut along the line between the lips, from corner to corner; points on it are doubled."""
    line = landmarks.points[list(LOOPS["lips_inner"])]
    half = len(line) // 2
    middle = (line[1:half] + line[:half:-1]) / 2
    middle = middle[np.isfinite(middle[:, 0])]
    if len(middle) < 2:
        return mesh
    middle = middle[np.argsort(middle[:, 0])]
    centre = mesh.vertices[mesh.faces].mean(1)
    over = centre[:, 1] - np.interp(centre[:, 0], middle[:, 0], middle[:, 1])
    across = (centre[:, 0] > middle[0, 0]) & (centre[:, 0] < middle[-1, 0])
    near = across & (np.abs(over) < LIPS_MM) & (centre[:, 2] > 0)
    lower = near & (over < 0)
    shared = np.intersect1d(mesh.faces[lower], mesh.faces[near & ~lower])
    doubles = np.arange(len(mesh.vertices))
    doubles[shared] = len(mesh.vertices) + np.arange(len(shared))
    faces = np.where(lower[:, None], doubles[mesh.faces], mesh.faces)
    return Mesh(np.concatenate([mesh.vertices, mesh.vertices[shared]]), faces)


def magnified(points: Float[np.ndarray, "n 3"], landmarks: MapLandmarks) -> Float[np.ndarray, "n 3"]:
    """Points pushed away from the middles of mouth and eyes, which makes the surface there larger."""
    out = points.copy()
    for loop, radius in CENTRES.items():
        corners = landmarks.points[list(LOOPS[loop])]
        away = points - np.nanmean(corners, axis=0)
        share = np.exp(-(away**2).sum(1) / radius**2)
        out += (MAGNIFIED - 1) * share[:, None] * away
    return out


def cylinder_uv(points: Float[np.ndarray, "n 3"], layout: CylinderLayout) -> Float[np.ndarray, "n 2"]:
    """The texture space of the neutral's map."""
    height, width = layout.shape
    x, y = layout.pixels(points).T
    return np.stack([(x + 0.5) / width, 1 - (y + 0.5) / height], 1)


def own_mesh(mesh: Mesh, neutral: CylinderMap, bundled: ArtistMesh, skin: Int[np.ndarray, " f"]) -> OwnMesh:
    """Any mesh that lies on the neutral, in its space.

    skin: triangles of the bundled mesh that are skin.

    Raises:
        BadInput: no uv, or it lies elsewhere.
    """
    if mesh.uv is None:
        raise BadInput("artist mesh: has no texture coordinates (uv); export it with them")
    mesh = with_corner_uv(mesh)
    artist = on_map(mesh, neutral)
    if artist.shown.mean() < LEAST_SHOWN:
        told = f"artist mesh: {artist.shown.mean():.0%} of its vertices lie on the neutral scan"
        raise BadInput(f"{told}; make it on what `mien scan` writes of it")
    near = closest_point(submesh(bundled.mesh, skin)[0], inwards(mesh)).attachment()
    onto = Attachment(skin[near.faces], near.barycentric).matrix(bundled.mesh)
    return OwnMesh(artist, onto)


def inwards(mesh: Mesh) -> Float[np.ndarray, "n 3"]:
    """Vertices half way to their neighbours' middle: those of a cut lie on its two sides, whose skin moves apart."""
    A = adjacency(mesh.faces, len(mesh.vertices))
    count = np.maximum(A.sum(1), 1)
    return (mesh.vertices + np.asarray(A @ mesh.vertices) / np.reshape(count, (-1, 1))) / 2


def taken_on(
    own: OwnMesh, source: CylinderMap, warp: SkinWarp, still: Transform
) -> tuple[Float[np.ndarray, "n 3"], Bool[np.ndarray, " n"]]:
    """An expression's displacements, mm, and which vertices it shows; the others follow those round them."""
    mesh = own.artist.mesh
    found = still.apply(look_up(own.artist, source, warp))
    seen = np.isfinite(found[:, 0])
    moved = np.where(seen[:, None], found - mesh.vertices, 0.0)
    return carry_on(mesh, moved, seen), seen
