"""A person's rig from colour alone: identity coefficients from landmarks in a few calm frames, then a bend to fit them.

No depth says how large the face is or how far its parts stand out: the identity space answers both with what is usual.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.interpolate import RBFInterpolator
from scipy.spatial import KDTree

from ...camera import Camera
from ...depth import RGBDFrame
from ...faces.bundled import BundledFace, load_face
from ...landmarks.detector import FaceLandmarker, Landmarks2D, bundled_landmarks
from ...landmarks.on_rig import LandmarkMap, bundled_map
from ...landmarks.stream import Landmarker
from ...progress import SILENT, Progress
from ...register import procrustes
from ...rgbd import RgbdTake
from ...rig import Rig
from ...rig.transfer import merged, transfer_rig
from ...transforms import Transform
from ..detect import detect
from ..model import tracking_model
from .calm_frames import Neutrality, calm_frames
from .personalize import PersonalizeConfig

FRAMES = 12
"""Calm frames that are looked at."""
ROUNDS = 6
SIGMA = 2.0
"""How far a landmark may lie from where the right identity would have it, mm: the weight of the prior."""
BEND_SMOOTHING, BEND_NEIGHBOURS = 20.0, 60
"""Of the thin plate through the landmarks' offsets: how little it follows a single one, and how many it hears."""
FADE = 40.0
"""Millimetres from the nearest landmark at which the bend has faded out."""


@dataclass(frozen=True)
class ImageRig:
    """A rig made without depth."""

    rig: Rig
    landmarks: LandmarkMap
    coefficients: Float[np.ndarray, " c"]
    """Identity, standard deviations."""
    average: float
    """Mean sideways distance of the landmarks from the average face's, mm."""
    fitted: float
    """The same after the identity fit, mm."""
    neutrality: Neutrality
    """How neutral the face was in the frames."""


def rig_from_images(
    take: RgbdTake,
    landmarker: Landmarker | None = None,
    config: PersonalizeConfig = PersonalizeConfig(),
    face: BundledFace | None = None,
    progress: Progress = SILENT,
) -> ImageRig:
    """A rig from the calm frames of a take, whose depth, if any, is not looked at.

    Raises:
        BadInput: no face in the first 30 frames.
    """
    face = face or load_face()
    looking = landmarker or FaceLandmarker("video")
    frames, found, neutrality = calm_frames(take, looking, config.first, config.frames, progress)
    chosen = np.unique(np.linspace(0, len(frames) - 1, min(FRAMES, len(frames))).astype(int))
    views = [(RGBDFrame(frames[i].color, None, frames[i].time), found[i]) for i in chosen]
    generic, a, errors = bundled_map(), np.zeros(len(face.identity.modes)), []
    for done in range(ROUNDS):
        poses = posed(face.person(a), generic, views, take.camera)
        a, before = identity_step(face, generic, a, poses, [marks for _, marks in views], take.camera)
        errors.append(before)
        progress.update("fitting the face", done + 1, ROUNDS)
    person = face.person(a)
    poses = posed(person, generic, views, take.camera)
    bent = bend_to_landmarks(person, generic, poses, [marks for _, marks in views], take.camera)
    neutral = of_usual_size(bent, face, generic)
    expressions = face.rig if config.shapes == "arkit" else merged(face.rig)
    rig = transfer_rig(expressions, person.neutral.with_vertices(neutral))
    return ImageRig(rig, generic, a, errors[0], errors[-1], neutrality)


def posed(
    rig: Rig, landmarks: LandmarkMap, views: list[tuple[RGBDFrame, Landmarks2D]], camera: Camera
) -> list[Transform]:
    """T_camera_face of every view, by the landmarks alone."""
    model = tracking_model(rig, landmarks)
    return [detect(model, frame, marks, camera) for frame, marks in views]


def identity_step(
    face: BundledFace,
    generic: LandmarkMap,
    a: Float[np.ndarray, " c"],
    poses: list[Transform],
    found: list[Landmarks2D],
    camera: Camera,
) -> tuple[Float[np.ndarray, " c"], float]:
    """Coefficients that bring the landmarks nearest to their lines of sight, and how far those were for `a`, mm."""
    ids = bundled_landmarks().stable
    weights, corners = generic.attachment.barycentric[ids], face.rig.neutral.faces[generic.attachment.faces[ids]]
    rest = np.einsum("pc,pcd->pd", weights, face.rig.neutral.vertices[corners])
    modes = np.einsum("pc,kpcd->pdk", weights, face.identity.modes[:, corners])
    gram, right, away = np.eye(len(a)) * SIGMA**2 * len(poses), np.zeros(len(a)), []
    for T, marks in zip(poses, found, strict=True):
        offset, rows = _sideways(T, rest, modes, marks.points[ids], camera)
        distance = np.linalg.norm(offset - np.einsum("pdk,k->pd", rows, a), axis=1)
        root = 1 / (1 + (distance / 6.0) ** 2)
        gram += np.einsum("p,pdk,pdl->kl", root, rows, rows)
        right += np.einsum("p,pdk,pd->k", root, rows, offset)
        away.append(distance.mean())
    return np.linalg.solve(gram, right), float(np.mean(away))


def _sideways(T: Transform, rest, modes, pixels, camera: Camera):
    """Offsets (p, 2) mm from the average's landmarks to their lines of sight, and what each mode does to them."""
    points, rays = T.apply(rest), camera.rays(pixels)[:, :2]
    turned = np.einsum("ad,pdk->pak", T.rotation, modes)
    rows = turned[:, :2] - rays[:, :, None] * turned[:, 2:]
    return rays * points[:, 2:] - points[:, :2], rows


def bend_to_landmarks(
    person: Rig, landmarks: LandmarkMap, poses: list[Transform], found: list[Landmarks2D], camera: Camera
) -> Float[np.ndarray, "n 3"]:
    """The neutral, bent smoothly so that its landmarks are seen where they were found, their depth as it was."""
    ids = bundled_landmarks().stable
    spots = landmarks.attachment.points(person.neutral)[ids]
    wanted = []
    for T, marks in zip(poses, found, strict=True):
        points = T.apply(spots)
        moved = camera.rays(marks.points[ids]) * points[:, 2:] - points
        wanted.append(moved @ T.rotation)
    offsets = np.median(wanted, axis=0)
    bend = RBFInterpolator(spots, offsets, smoothing=BEND_SMOOTHING, neighbors=BEND_NEIGHBOURS, degree=1)
    vertices = person.neutral.vertices.copy()
    away = KDTree(spots).query(vertices)[0]
    near = away < FADE
    vertices[near] += bend(vertices[near]) * (1 + np.cos(np.pi * away[near] / FADE))[:, None] / 2
    return vertices


def of_usual_size(
    neutral: Float[np.ndarray, "n 3"], face: BundledFace, landmarks: LandmarkMap
) -> Float[np.ndarray, "n 3"]:
    """The neutral, mm, made as large as the average face by its landmarks.

    A picture says nothing of size; the fit takes for perspective what sets landmarks apart, and ends 2 to 3 % small.
    """
    ids = bundled_landmarks().stable
    corners = face.rig.neutral.faces[landmarks.attachment.faces[ids]]
    weights = landmarks.attachment.barycentric[ids]
    own, usual = (np.einsum("pc,pcd->pd", weights, v[corners]) for v in (neutral, face.rig.neutral.vertices))
    return neutral * procrustes(own, usual, scale=True).transform.scale
