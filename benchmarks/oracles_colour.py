"""What a take allows at best where its depth is not looked at: asked by `oracles.py --only colour`, `--staged`."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from shares import strongest
from tracking_accuracy import performance, shot

from mien.faces.bundled import load_face
from mien.landmarks.detector import FaceLandmarker, Landmarks2D
from mien.mesh import Attachment, ClosestPoint, Mesh
from mien.register.rigid import procrustes
from mien.register.rigid_icp import IcpConfig, icp, pose_step
from mien.rgbd import read_rgbd
from mien.rgbd.intrinsics import assumed_camera
from mien.rgbd.take import RgbdTake
from mien.stage import make_performer
from mien.stage.people.make_performer import STRANGER
from mien.tracking.person.personalize import personalize
from mien.tracking.person.rig_from_images import rig_from_images
from mien.tracking.pipeline import T_WORLD_CAMERA, track_take
from mien.tracking.rigid import moved
from mien.transforms import Transform, skew, stacked, vector_from_rotation

RATE = 30.0
"""Frames a second of the colour images, which do not say."""
ROUNDS = 8
"""Solves of a pose with new weights: it has come to rest before."""
STRAY_MM = 1.0
"""Skin that lies so far off its line of sight counts a quarter."""
TAKEN = {"distance": (2,), "place": (0, 1, 2)}
"""Which coordinates of the place each oracle knows, camera space."""


@dataclass(frozen=True)
class Played:
    """What was played, and where."""

    T_camera_head: Transform
    """A pose a frame."""
    neutral: np.ndarray
    """The skin that is judged, head space, mm (v, 3)."""
    motion: np.ndarray
    """From it, head space, mm (t, v, 3)."""
    calm: int
    """A frame in which the face is in its neutral."""

    @cached_property
    def placed(self) -> np.ndarray:
        """The skin, camera space, mm (t, v, 3)."""
        return self.T_camera_head.apply(self.neutral + self.motion)


@dataclass(frozen=True)
class Followed:
    """The same skin's points on a tracked rig."""

    T_camera_face: Transform
    neutral: np.ndarray
    """Rig space, mm (v, 3)."""
    motion: np.ndarray
    """From it, rig space, mm (t, v, 3)."""
    places: Attachment
    """Where they are on the rig."""
    T_true_found: Transform
    """From the camera that was assumed to the true one: one motion for the take, as nobody knows its distance."""

    @cached_property
    def T_head(self) -> Transform:
        """The rig in the true camera's space, a pose a frame."""
        return self.T_true_found @ self.T_camera_face


@dataclass(frozen=True)
class Seen:
    """A film's landmarks, looked for once."""

    marks: list[Landmarks2D | None]

    def detect(self, image: np.ndarray, time: float | None = None) -> Landmarks2D | None:
        """What was found in the frame of that time."""
        return self.marks[round((time or 0.0) * RATE)]


def colour(folder: Path) -> None:
    """Every oracle of one take."""
    known = dict(np.load(folder / "truth.npz"))
    skin = known["open"]
    played = Played(
        T_camera_head=Transform(known["rotation"].astype(float), known["translation"].astype(float)),
        neutral=known["neutral"][skin].astype(float),
        motion=np.tensordot(known["coefficients"], known["modes"][:, skin], 1).astype(float),
        calm=int(np.flatnonzero(known["still"])[0]),
    )
    take, full = read_rgbd(folder / "take" / "color", rate=RATE), read_rgbd(folder / "take")
    seen = looked_at(take)
    made = rig_from_images(take, seen)
    found = as_tracked(played, take, seen, made)
    for what in ("distance", "place", "turn", "pose"):
        say(f"colour, with the true {what}", played, with_true(played, found, what))
    names = [str(name) for name in known["arkit_names"]]
    weights = known["arkit"][:, [names.index(name) for name in made.rig.names]]
    shapes = np.stack([found.places.points(made.rig.neutral.with_vertices(delta)) for delta in made.rig.deltas])
    as_played = replace(found, motion=np.tensordot(weights, shapes, 1))
    T_face_head = found.T_head[played.calm].inverse() @ played.T_camera_head[played.calm]
    truly = replace(found, motion=T_face_head.rotate(played.motion))
    rays = take.camera.rays(full.camera.project(played.placed))[..., :2]
    told = (("as tracked", found), ("weights as played", as_played), ("the true motion", truly))
    for what, motion in told:
        say(f"colour, head by the true picture of all skin, {what}", played, seen_there(motion, rays))
    say("colour, weights as played, the true pose", played, with_true(played, as_played, "pose"))
    say("colour, the true lens", played, tracked(played, replace(take, camera=full.camera), seen, made))
    say("colour, a rig made with depth", played, tracked(played, take, seen, personalize(full, seen)))


def staged(seed: int, kind: str, seconds: float) -> None:
    """The tracked colour of a staged performer's film, its depth not looked at."""
    actor = make_performer(seed, STRANGER if kind == "stranger" else None)
    film = shot(actor, performance(seed, seconds), seed=seed)
    truth, face = film.truth, load_face().regions["face"] > 0.5
    neutral = truth.neutral.vertices
    played = Played(truth.T_lab_face, neutral[face], (truth.vertices() - neutral)[:, face], calm=5)
    plain = [replace(frame, depth=None) for frame in film.frames]
    camera = assumed_camera(film.take.camera.width, film.take.camera.height, None)
    take = replace(film.take, camera=camera, has_depth=False, frames=lambda: iter(plain))
    seen = Seen(film.marks)
    as_tracked(played, take, seen, rig_from_images(take, seen), f"staged {kind} {seed}")


def looked_at(take: RgbdTake) -> Seen:
    """The take's landmarks."""
    with FaceLandmarker("video") as eyes:
        return Seen([None if frame.color is None else eyes.detect(frame.color, frame.time) for frame in take])


def as_tracked(played: Played, take: RgbdTake, seen: Seen, made, what: str = "colour") -> Followed:
    """Track it, and say how far it is off, and where."""
    found = tracked(played, take, seen, made)
    say(f"{what}, tracked", played, found)
    off, turn = errors(played, found)
    mm, degrees = off.std(axis=0), np.degrees(turn).std(axis=0)
    print(f"{what}, the head's deviation: across {mm[0]:.1f} and {mm[1]:.1f} mm, in distance {mm[2]:.1f} mm; "
          f"nodding {degrees[0]:.1f}, turning {degrees[1]:.1f}, tilting {degrees[2]:.1f} degrees")  # fmt: skip
    return found


def tracked(played: Played, take: RgbdTake, seen: Seen, made) -> Followed:
    """Track the take on a rig, and follow the true skin's points on it from the calm frame."""
    performance = track_take(take, made.rig, made.landmarks, seen).performance
    T_camera_face = T_WORLD_CAMERA.inverse() @ performance.T_world_face
    rig, calm = performance.rig, played.calm
    there = T_camera_face[calm].apply(rig.vertices(performance.weights[calm]))
    surface = ClosestPoint(Mesh(there, rig.neutral.faces))
    near = T_camera_face[calm].apply(made.landmarks.attachment.points(rig.neutral)).mean(axis=0)
    near = near - played.placed[calm].mean(axis=0)
    laid = icp(played.placed[calm], surface, Transform(np.eye(3), near), IcpConfig(metric="plane")).transform
    bound = surface.query(laid.apply(played.placed[calm]))
    places = Attachment(bound.faces, bound.barycentric)
    neutral = places.points(rig.neutral)
    moving = np.stack([places.points(rig.neutral.with_vertices(rig.vertices(w))) for w in performance.weights])
    placed = T_camera_face.apply(moving)
    back = procrustes(placed.reshape(-1, 3), played.placed.reshape(-1, 3)).transform
    return Followed(T_camera_face, neutral, moving - neutral, places, back)


def say(what: str, played: Played, found: Followed) -> None:
    """One line: errors of the skin's motion, take / strongest tenth, % of frozen."""
    T_head_face = played.T_camera_head.inverse() @ found.T_head
    own = T_head_face.rotate(found.motion) - played.motion
    world = T_head_face.apply(found.neutral + found.motion) - played.motion
    frozen = np.linalg.norm(played.motion - played.motion.mean(axis=0), axis=2)
    strong, cells = strongest(played.motion), []
    for name, error in (("own", own), ("mean removed", own - own.mean(axis=0)), ("world", world - world.mean(axis=0))):
        size = np.linalg.norm(error, axis=2)
        take, tenth = (100 * size[rows].mean() / frozen[rows].mean() for rows in (slice(None), strong))
        cells.append(f"{name} {take:.0f} / {tenth:.0f}")
    print(f"{what}: {', '.join(cells)}", flush=True)


def errors(played: Played, found: Followed) -> tuple[np.ndarray, np.ndarray]:
    """How far the head is off where it was in the calm frame: camera space, mm, and radians of head space (t, 3)."""
    T_head_face = played.T_camera_head.inverse() @ found.T_head
    here = T_head_face[played.calm]
    middle = played.neutral.mean(axis=0)
    point = here.inverse().apply(middle[None])
    off = played.T_camera_head.rotate(T_head_face.apply(point) - middle)[:, 0]
    return off, vector_from_rotation(T_head_face.rotation @ here.rotation.T)


def with_true(played: Played, found: Followed, what: str) -> Followed:
    """The same with a part of the head's motion as it truly was."""
    T_head_face = played.T_camera_head.inverse() @ found.T_head
    here = T_head_face[played.calm]
    truly = played.T_camera_head @ here
    if what == "pose":
        return replace(found, T_camera_face=found.T_true_found.inverse() @ truly)
    point = here.inverse().apply(played.neutral.mean(axis=0)[None])
    if what == "turn":
        stays = found.T_head.apply(point)[:, 0]
        turned = Transform(truly.rotation, stays - np.einsum("tij,j->ti", truly.rotation, point[0]))
        return replace(found, T_camera_face=found.T_true_found.inverse() @ turned)
    off, _ = errors(played, found)
    wrong = np.zeros_like(off)
    for axis in TAKEN[what]:
        wrong[:, axis] = (off - off.mean(axis=0))[:, axis]
    shifted = Transform(found.T_head.rotation, found.T_head.translation - wrong)
    return replace(found, T_camera_face=found.T_true_found.inverse() @ shifted)


def seen_there(found: Followed, rays: np.ndarray) -> Followed:
    """The head of each frame from the lines of sight (t, v, 2) of all its skin; what is far off them loses weight."""
    T, moving = found.T_camera_face, found.neutral + found.motion
    return replace(found, T_camera_face=stacked([one_seen(moving[i], rays[i], T[i]) for i in range(len(T))]))


def one_seen(points: np.ndarray, rays: np.ndarray, T: Transform) -> Transform:
    """The pose that brings points (v, 3) onto lines of sight (v, 2): Gauss-Newton, after Geman and McClure."""
    for _ in range(ROUNDS):
        placed = T.apply(points)
        centre = placed.mean(axis=0)
        motion = np.concatenate([-skew(placed - centre), np.broadcast_to(np.eye(3), (len(placed), 3, 3))], axis=2)
        rows = motion[:, :2] - rays[:, :, None] * motion[:, 2:]
        off = rays * placed[:, 2:] - placed[:, :2]
        weight = 1 / (1 + (off**2).sum(axis=1) / STRAY_MM**2) ** 2
        A = np.einsum("n,nij,nik->jk", weight, rows, rows)
        T = moved(T, pose_step(A, np.einsum("n,nij,ni->j", weight, rows, off)), centre)
    return T
