"""Textured blendshapes against the stage's truth: by true correspondence, never by closest points alone."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ..blendshapes.build.artist_mesh import ArtistMesh
from ..blendshapes.cylinder_map import CylinderMap
from ..faces.bundled import load_face
from ..mesh import Attachment, ClosestPoint, Mesh, face_areas
from ..register.correspond import Rejection
from ..register.rigid_icp import IcpConfig, icp
from ..stage import Performer, Skin
from ..transforms import Transform

NEAR_MM = 1.0
"""Artist vertices farther than this from the true neutral are not scored: they stand for no skin."""
FRONT_MM = 40.0
"""Depth in face space of the map's points that lay it on the truth."""


@dataclass(frozen=True)
class TrueSkin:
    """Where the truth has the skin under each artist vertex."""

    actor: Performer | Skin
    T_map_true: Transform
    material: Attachment
    scored: np.ndarray
    """Vertices (n,) on the face."""
    neutral_mm: float
    """Mean distance of the neutral map's front from the true surface, mm."""

    def points(self, weights: Float[np.ndarray, " shapes"]) -> Float[np.ndarray, "n 3"]:
        """Where that skin is under an expression, in the neutral map's frame, mm."""
        return self.material.points(self.mesh(weights))

    def mesh(self, weights: Float[np.ndarray, " shapes"]) -> Mesh:
        """The true surface in the neutral map's frame."""
        vertices = self.actor.vertices(weights[None])[0]
        return Mesh(self.T_map_true.apply(vertices), self.actor.neutral.faces)


def true_skin(actor: Performer | Skin, neutral: CylinderMap, artist: ArtistMesh) -> TrueSkin:
    """The truth laid on the neutral map: by ICP, since no file says where the head was."""
    tree = ClosestPoint(actor.neutral)
    front = neutral.known & (neutral.confidence > 0.2) & (neutral.positions[..., 2] > FRONT_MM)
    points = neutral.positions[front].astype(np.float64)
    rule = Rejection(max_distance=6.0, max_angle_deg=180)
    T = icp(points, tree, config=IcpConfig(robust="tukey", max_points=6000, rejection=rule)).transform
    near = tree.query(T.apply(artist.mesh.vertices))
    scored = (load_face().regions["face"] > 0.5) & artist.shown & (near.distances < NEAR_MM)
    off = tree.query(T.apply(points[::20])).distances
    return TrueSkin(actor, T.inverse(), near.attachment(), scored, float(off.mean()))


def drift(
    truth: TrueSkin, found: Float[np.ndarray, "n 3"], weights: Float[np.ndarray, " shapes"], artist: Mesh, size: int
) -> Float[np.ndarray, " n"]:
    """Texture drift: how far the skin found for each vertex lies from its own at rest, texels of a `size`^2 texture."""
    seen = np.isfinite(found[:, 0])
    material = ClosestPoint(truth.mesh(weights)).query(np.nan_to_num(found)).attachment()
    rest = truth.mesh(np.zeros_like(weights))
    off = np.linalg.norm(material.points(rest) - truth.material.points(rest), axis=1)
    return np.where(seen, off * texels_a_mm(artist, size), np.nan)


def texels_a_mm(mesh: Mesh, size: int) -> float:
    """Texels along a millimetre of the face, root mean square over its triangles."""
    assert mesh.uv is not None
    corners = mesh.uv[mesh.faces if mesh.uv_faces is None else mesh.uv_faces]
    b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    flat = np.abs(b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]) / 2
    front = (load_face().regions["face"][mesh.faces] > 0.5).all(1)
    areas = face_areas(mesh.vertices, mesh.faces)
    return float(size * np.sqrt(flat[front].sum() / areas[front].sum()))
