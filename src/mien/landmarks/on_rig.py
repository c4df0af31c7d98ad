"""Which of MediaPipe's 478 landmarks are the paper's 40 features, and where all of them lie on a rig's surface."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, UInt8

from ..camera import Camera
from ..errors import BadInput
from ..faces.bundled import load_face
from ..files import whole
from ..mesh import Attachment, ClosestPoint, Mesh, in_largest_part, vertex_normals
from ..pictures.raycast import DepthImage, depth_image
from ..rig import Rig
from ..transforms import Transform, rotation_from_vector
from .detector import COUNT, FaceLandmarker, bundled_landmarks

OUTER_LIPS = (61, 40, 37, 267, 270, 291, 321, 314, 84, 91)
UPPER_INNER_LIP = (81, 13, 311)
LOWER_INNER_LIP = (178, 14, 402)
RIGHT_EYE = (33, 160, 159, 158, 133, 153, 145, 144)
LEFT_EYE = (263, 387, 386, 385, 362, 380, 374, 373)
BROWS = (70, 105, 66, 107, 300, 334, 296, 336)
FEATURES = (*OUTER_LIPS, *UPPER_INNER_LIP, *LOWER_INNER_LIP, *RIGHT_EYE, *LEFT_EYE, *BROWS)
"""The 40 features of Li et al. 2013 (lip contours 16, eye contours 16, eyebrows 8) as MediaPipe's indices."""

LIDS = ((159, 145), (160, 144), (158, 153), (386, 374), (387, 373), (385, 380))
"""Upper and lower lid, across the opening."""
LIPS = tuple(zip(UPPER_INNER_LIP, LOWER_INNER_LIP, strict=True))
"""Upper and lower lip, across the opening."""
IRISES = range(468, COUNT)

VIEWS = ((0.0, 0.0), (0.0, 0.18), (0.0, -0.18), (0.12, 0.0), (-0.12, 0.0))
"""Tilt and turn, radians, under which a rig is looked at to find its landmarks."""


@dataclass(frozen=True)
class LandmarkMap:
    """The 478 landmarks as points of a rig's surface."""

    attachment: Attachment
    """478 points on the rig's neutral mesh; an unknown one is somewhere."""
    known: Bool[np.ndarray, " 478"]

    def save(self, path: str | Path) -> None:
        """Write `path`, a JSON file that lies beside the rig: triangle and weights a landmark, null where unknown."""
        rows = [
            [int(face), *(round(float(w), 5) for w in weights)] if known else None
            for face, weights, known in zip(self.attachment.faces, self.attachment.barycentric, self.known, strict=True)
        ]
        with whole(path) as temporary:
            temporary.write_text(json.dumps({"landmarks": rows}))

    @staticmethod
    def load(path: str | Path, mesh: Mesh) -> "LandmarkMap":
        """Read what `save` wrote for `mesh`.

        Raises:
            BadInput: not such a file, or not for this mesh.
        """
        try:
            rows = json.loads(Path(path).read_text())["landmarks"]
            table = np.array([row or [-1, 0, 0, 0] for row in rows], float)
        except (ValueError, KeyError, TypeError, OverflowError) as error:
            raise BadInput(f"{path}: not a landmark file ({error}); make it anew with `mien personalize`") from error
        if table.shape != (COUNT, 4) or not np.isfinite(table).all() or not (table[:, 0] < len(mesh.faces)).all():
            raise BadInput(f"{path}: written for another rig; make it anew with `mien personalize`")
        known = table[:, 0] >= 0
        return LandmarkMap(Attachment(np.maximum(table[:, 0], 0).astype(int), table[:, 1:]), known)


def bundled_map() -> LandmarkMap:
    """Where the landmarks are on the bundled face, and on every face of its topology."""
    return LandmarkMap(bundled_landmarks().attachment, np.ones(COUNT, bool))


def landmarks_of(rig: Rig) -> LandmarkMap:
    """The landmarks of any rig: known for the bundled topology, else looked for.

    Raises:
        BadInput: no face is found in pictures of the rig.
    """
    if np.array_equal(rig.neutral.faces, load_face().rig.neutral.faces):
        return bundled_map()
    return find_landmarks(rig)


def find_landmarks(rig: Rig, landmarker: FaceLandmarker | None = None) -> LandmarkMap:
    """Where the landmarks are on a rig: it is rendered from five sides, looked at, and what is seen is averaged.

    The inner lips are looked up with the jaw dropped, where the rig can, since on a closed mouth they are one line.

    Raises:
        BadInput: no face is found in the pictures of the rig.
    """
    with landmarker or FaceLandmarker() as eyes:
        known, closed = _seen_on(rig, rig.neutral, eyes)
        if "jawOpen" in rig.names:
            weights = np.zeros(len(rig.names))
            weights[rig.index("jawOpen")] = 0.4
            open_known, opened = _seen_on(rig, rig.mesh(weights), eyes)
            inner = np.array([*UPPER_INNER_LIP, *LOWER_INNER_LIP])
            closed[inner] = np.where(open_known[inner, None], opened[inner], closed[inner])
    if not known[list(FEATURES)].all():
        raise BadInput("the rig does not look like a face from the front; landmarks cannot be placed on it")
    return attach_landmarks(rig.neutral, np.nan_to_num(closed), known)


def attach_landmarks(mesh: Mesh, points: Float[np.ndarray, "478 3"], known: Bool[np.ndarray, " 478"]) -> LandmarkMap:
    """Landmarks at `points` (mm) fixed on the skin nearest to them, the irises on whatever is nearest."""
    skin = np.flatnonzero(skin_faces(mesh))
    on_skin = ClosestPoint(Mesh(mesh.vertices, mesh.faces[skin])).query(points)
    anywhere = ClosestPoint(mesh).query(points)
    iris = np.arange(COUNT) >= IRISES.start
    faces = np.where(iris, anywhere.faces, skin[on_skin.faces])
    return LandmarkMap(Attachment(faces, np.where(iris[:, None], anywhere.barycentric, on_skin.barycentric)), known)


def skin_faces(mesh: Mesh) -> Bool[np.ndarray, " m"]:
    """The triangles of the largest connected part: the skin, without eyeballs, teeth and tongue."""
    return in_largest_part(mesh.faces, len(mesh.vertices))


def _seen_on(rig: Rig, mesh: Mesh, eyes: FaceLandmarker) -> tuple[np.ndarray, np.ndarray]:
    """Landmarks seen on `mesh`, as points of the neutral: known (478,), median over the views (478, 3)."""
    views = []
    for tilt, turn in VIEWS:
        camera, T_camera_face = view_of_face(mesh, tilt, turn)
        picture, hits = shade(mesh, camera, T_camera_face)
        found = eyes.detect(picture)
        if found is not None:
            views.append(lift(found.points, hits, rig.neutral))
    if not views:
        return np.zeros(COUNT, bool), np.full((COUNT, 3), np.nan)
    seen = np.stack(views)
    known = np.asarray(np.isfinite(seen[..., 0]).any(0))
    seen[:, ~known] = 0
    return known, np.nanmedian(seen, axis=0)


def lift(pixels: Float[np.ndarray, "p 2"], hits: DepthImage, neutral: Mesh) -> Float[np.ndarray, "p 3"]:
    """The neutral's points under `pixels` of an image of the mesh; NaN off it."""
    h, w = hits.faces.shape
    u, v = np.round(pixels).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < w) & (v < h)
    u, v = np.clip(u, 0, w - 1), np.clip(v, 0, h - 1)
    faces = hits.faces[v, u]
    points = np.einsum("pc,pcd->pd", np.nan_to_num(hits.barycentric[v, u]), neutral.vertices[neutral.faces[faces]])
    return np.where((inside & (faces >= 0))[:, None], points, np.nan)


def view_of_face(mesh: Mesh, tilt: float = 0.0, turn: float = 0.0, size: int = 480) -> tuple[Camera, Transform]:
    """A camera 700 mm in front of a head in face space, turned by `tilt` about x and `turn` about y (radians)."""
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    turned = rotation_from_vector(np.array([tilt, 0.0, 0.0])) @ rotation_from_vector(np.array([0.0, turn, 0.0]))
    R = np.diag([1.0, -1.0, -1.0]) @ turned
    middle = R @ ((low + high) / 2)
    focal = 0.8 * size * 700 / float((high - low)[1])
    half = (size - 1) / 2
    return Camera(focal, focal, half, half, size, size), Transform(R, np.array([0.0, 0.0, 700.0]) - middle)


def shade(mesh: Mesh, camera: Camera, T_camera_face: Transform) -> tuple[UInt8[np.ndarray, "h w 3"], DepthImage]:
    """A plainly lit picture of a mesh in its vertex colours (skin tone where it has none), and its `DepthImage`."""
    hits = depth_image(mesh, camera, T_camera_face)
    on = hits.faces >= 0
    corners = mesh.faces[hits.faces[on]]
    colors = np.tile([0.78, 0.6, 0.52], (len(mesh.vertices), 1)) if mesh.colors is None else mesh.colors
    normals = T_camera_face.rotate(vertex_normals(mesh.vertices, mesh.faces))
    blend = hits.barycentric[on]
    lit = np.einsum("pc,pcd->pd", blend, normals[corners]) @ np.array([-0.3, -0.4, -0.87])
    tone = np.einsum("pc,pcd->pd", blend, colors[corners]) * (0.35 + 0.65 * np.clip(lit, 0, 1))[:, None]
    picture = np.full((camera.height, camera.width, 3), 90, np.uint8)
    picture[on] = np.clip(tone * 255, 0, 255).astype(np.uint8)
    return picture, hits


def feature_points(map_: LandmarkMap, mesh: Mesh) -> Float[np.ndarray, "478 3"]:
    """The landmarks on `mesh`, a shape of the rig, mm; NaN where unknown."""
    return np.where(map_.known[:, None], map_.attachment.points(mesh), np.nan)
