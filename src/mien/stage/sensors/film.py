"""A performance before an RGB-D camera: light, shoulders, a wall, hands in the way, walks out of the picture."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, UInt8

from ...camera import Camera
from ...depth import RGBDFrame
from ...errors import BadInput
from ...mesh import Mesh, face_normals
from ...pictures.raycast import DepthImage, depth_image
from ...pictures.render import Look, Renderer
from ...pictures.show import side_by_side
from ...rgbd import RgbdTake
from ...transforms import Transform, rotation_from_vector, vector_from_rotation
from ..people.performer import Performer
from ..people.skin import Skin
from ..script.script import minimum_jerk
from ..truth import Truth
from .depth_sensor import DepthSensor, Seen, cut_noise, record, structured_light
from .mocap import NECK, HeadMotion, head_motion
from .occluders import hand, join, shoulders
from .worn import Kind, wear

LIGHT = Look(supersample=2, occlusion=0, background=((0.47, 0.46, 0.44), (0.36, 0.36, 0.36)))


@dataclass(frozen=True)
class FilmConfig:
    """The stage before the camera."""

    sensor: DepthSensor = field(default_factory=structured_light)
    distance: float = 680.0
    """From the camera to the resting head, mm."""
    head: HeadMotion = HeadMotion(rotation=0.13, translation=14.0)
    """How the head moves."""
    sweep: float = 0.0
    """The head also turns so far to either side, and half as far up and down, radians, once over the film. 0: no."""
    wall: float = 1400.0
    """Distance of the wall behind, mm. 0: none."""
    colour_noise: float = 2.0
    """Standard deviation of a colour channel, of 255. 0: none."""
    occlusions: tuple[tuple[float, float], ...] = ()
    """(when, how long) a hand is held before the face, seconds."""
    absences: tuple[tuple[float, float], ...] = ()
    """(when, how long) the head is out of the picture, seconds; it takes 0.4 s either way."""
    depth_late: float = 0.0
    """Depth shows what was so long before its colour image, seconds. 0: together."""
    shutter: float = 0.0
    """How long a colour image is exposed, seconds: what moves meanwhile is blurred. 0: an instant."""
    distortion: float = 0.0
    """The lens's radial k1 that the camera's numbers know nothing of, for colour and depth. 0: none."""
    worn: tuple[Kind, ...] = ()
    """What is worn: "hair" over the forehead, a "beard", "glasses"."""
    look: Look = LIGHT
    """The light."""


HARD_FILM = FilmConfig(
    depth_late=0.012, shutter=0.012, distortion=-0.02, colour_noise=4.0, worn=("hair",), occlusions=((2.0, 0.4),)
)
"""A film as a webcam with a depth sensor gives it at home. Play a `Skin`: bare performers have no pores or wrinkles."""
BLUR_SAMPLES = 3
"""Moments that a blurred image is the mean of."""


@dataclass(frozen=True)
class StagedFilm:
    """An RGB-D take and the truth behind it."""

    take: RgbdTake
    """The only thing that a solver may see. Frames are made as they are asked for, the same at every walk."""
    truth: Truth


def film(
    actor: Performer | Skin,
    weights: Float[np.ndarray, "frames shapes"],
    rate: float = 30.0,
    config: FilmConfig | None = None,
    seed: int = 0,
) -> StagedFilm:
    """Play `weights` before a depth camera. The truth's lab is the colour camera's space (x right, y down, z forward).

    Raises:
        BadInput: weights of the wrong width, or a head nearer than the sensor can see.
    """
    config = config or FilmConfig()
    if weights.shape[1] != len(actor.names):
        raise BadInput(f"weights: expected {len(actor.names)} a frame, one a unit, got {weights.shape[1]}")
    if config.distance < config.sensor.nearest + 150:
        least = config.sensor.nearest + 150
        raise BadInput(f"distance: expected at least {least:.0f} mm for this sensor, got {config.distance:.0f}")
    stage = _Stage(actor, weights, rate, config, seed)
    t = np.arange(len(weights)) / rate
    hidden = _during(t, config.occlusions, 0.25) + _during(t, config.absences, 0.4)
    truth = Truth(actor, weights, stage.T_camera_face, rate, in_view=hidden < 0.3)
    take = RgbdTake(f"stage {seed}", config.sensor.camera, rate, len(weights), True, stage.frames)
    return StagedFilm(take, truth)


class _Stage:
    """Everything that stays, and the making of one frame."""

    def __init__(self, actor: Performer | Skin, weights: np.ndarray, rate: float, config: FilmConfig, seed: int):
        self.actor, self.weights, self.rate, self.config, self.seed = actor, weights, rate, config, seed
        self.T_camera_face = _poses(len(weights), rate, config, np.random.default_rng([seed, 9]))
        performer = actor.performer if isinstance(actor, Skin) else actor
        neck = performer.neutral.vertices[performer.skin]
        low = float(neck[:, 1].min())
        self._body = shoulders(np.array([0.0, low + 12, neck[neck[:, 1] < low + 8, 2].mean()]))
        self._hand = hand()
        self._worn = [wear(actor, kind, seed) for kind in config.worn]
        self._scene = join([actor.neutral, self._body, self._hand, *(w.mesh for w in self._worn)])
        self._renderer = Renderer(self._scene, config.look)
        assert self._scene.colors is not None
        self._brightness = self._scene.colors[self._scene.faces[:, 0]].mean(axis=1)

    def frames(self) -> Iterator[RGBDFrame]:
        """Frame after frame, made side by side on all cores."""
        yield from side_by_side(self.frame, range(len(self.weights)))

    def frame(self, i: int) -> RGBDFrame:
        """One frame; its noise is its own, the same at every walk."""
        rng = np.random.default_rng([self.seed, 10, i])
        camera, config, time = self.config.sensor.camera, self.config, i / self.rate
        still = Transform.identity()
        scene = self._placed(time - config.depth_late)
        picture = self._exposed(time)
        hits = depth_image(scene, camera, still)
        depth = record(self._seen(scene, hits), config.sensor, rng)
        if config.distortion:
            picture, depth = (lens_distorted(image, camera, config.distortion) for image in (picture, depth))
        return RGBDFrame(_noisy(picture, config.colour_noise, rng), depth, time)

    def _exposed(self, time: float) -> UInt8[np.ndarray, "h w 3"]:
        """The picture of one moment, or the mean over the shutter's time before it."""
        camera, still = self.config.sensor.camera, Transform.identity()
        moments = [time]
        if self.config.shutter > 0:
            moments = list(time - self.config.shutter * np.linspace(0, 1, BLUR_SAMPLES))
        drawn = [self._renderer.draw(camera, still, vertices=self._placed(t).vertices) for t in moments]
        return np.mean(drawn, axis=0).round().astype(np.uint8)

    def _at(self, time: float) -> tuple[Transform, Float[np.ndarray, " shapes"]]:
        """Head pose and weights between two frames; held before the first."""
        at = float(np.clip(time * self.rate, 0, len(self.weights) - 1))
        i = min(int(at + 1e-9), len(self.weights) - 1)
        share, j = max(at - i, 0.0), min(i + 1, len(self.weights) - 1)
        if share < 1e-9:
            return self.T_camera_face[i], self.weights[i]
        R, t = self.T_camera_face.rotation, self.T_camera_face.translation
        between = rotation_from_vector(share * vector_from_rotation(R[j] @ R[i].T))
        pose = Transform(between @ R[i], (1 - share) * t[i] + share * t[j])
        return pose, (1 - share) * self.weights[i] + share * self.weights[j]

    def _placed(self, moment: float) -> Mesh:
        """Head, shoulders, hand and what is worn in camera space."""
        (T, weights), time = self._at(moment), np.array([moment])
        face = self.actor.vertices(weights[None])[0]
        head, worn = T.apply(face), [T.apply(w.vertices(face, self.actor.neutral.faces)) for w in self._worn]
        sway = T.translation * 0.9 + [0.0, 0.0, 0.1 * self.config.distance]
        upright = Transform(np.diag([1.0, -1.0, -1.0]), sway)
        near = float(_during(time, self.config.occlusions, 0.25)[0])
        away = np.array([420.0 * (1 - near) + 8.0, 30.0 + 150.0 * (1 - near), -115.0])
        swing = rotation_from_vector(np.array([0.0, 0.0, 0.5 * (1 - near)]))
        flat = self._hand.vertices * [1, -1, -1] @ swing.T + T.translation + away + [0, 0, -70]
        return self._scene.with_vertices(np.concatenate([head, upright.apply(self._body.vertices), flat, *worn]))

    def _seen(self, scene: Mesh, hits: DepthImage) -> Seen:
        """Exact depth, angles, the projector's shadow, brightness; the wall where nothing else is."""
        camera, config = self.config.sensor.camera, self.config
        hit = hits.faces >= 0
        depth = np.where(hit, hits.depth, config.wall if config.wall > 0 else np.nan)
        pixels = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1).astype(np.float64)
        rays = camera.rays(pixels)
        facing = 1.0 / np.linalg.norm(rays, axis=-1)
        brightness = np.full(depth.shape, 0.5)
        normals = face_normals(scene.vertices, scene.faces)
        seen = hits.faces[hit]
        facing[hit] *= np.abs((normals[seen] * rays[hit]).sum(axis=1))
        brightness[hit] = self._brightness[seen]
        return Seen(depth, facing, self._lit(scene, rays[..., 0] * depth, depth), brightness)

    def _lit(
        self, scene: Mesh, x: Float[np.ndarray, "h w"], z: Float[np.ndarray, "h w"]
    ) -> Bool[np.ndarray, "h w"]:
        """Whether the projector, `baseline` to the left of the camera, reaches the point of each pixel.

        Its own z-buffer says. Rows are the same in both views.
        """
        sensor = self.config.sensor
        if sensor.baseline <= 0:
            return np.ones(z.shape, dtype=bool)
        view = _wider(sensor.camera)
        aside = Transform(np.eye(3), np.array([sensor.baseline, 0.0, 0.0]))
        nearest = np.nan_to_num(depth_image(scene, view, aside).depth, nan=np.inf)
        there = z > 0
        column = np.round(view.fx * (x[there] + sensor.baseline) / z[there] + view.cx).astype(int)
        lit = np.zeros(z.shape, dtype=bool)
        lit[there] = z[there] < nearest[np.nonzero(there)[0], np.clip(column, 0, view.width - 1)] + 6.0
        return lit


def lens_distorted(image: np.ndarray, camera: Camera, k1: float) -> np.ndarray:
    """The image as a lens of radial distortion `k1` gives it, after Brown: r' = r (1 + k1 r^2), r in focal lengths.

    Nearest pixels, so that depths are not mixed.
    """
    v, u = np.mgrid[: camera.height, : camera.width]
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    there = 1.0
    for _ in range(4):
        squared = (x * x + y * y) * there * there
        there = 1.0 / (1 + k1 * squared)
    column = np.clip(np.round(camera.fx * x * there + camera.cx), 0, camera.width - 1).astype(int)
    row = np.clip(np.round(camera.fy * y * there + camera.cy), 0, camera.height - 1).astype(int)
    return image[row, column]


def _wider(camera: Camera) -> Camera:
    """The projector's view: the camera's, half as wide again."""
    more = camera.width // 4
    return Camera(camera.fx, camera.fy, camera.cx + more, camera.cy, camera.width + 2 * more, camera.height)


def _poses(frames: int, rate: float, config: FilmConfig, rng: np.random.Generator) -> Transform:
    """Face to camera: the head before the lens, moving, and gone sideways during absences."""
    moving = head_motion(frames, rate, config.head, rng)
    before = Transform(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, config.distance + 80.0]))
    T = before @ moving @ _swept(frames, config.sweep)
    gone = _during(np.arange(frames) / rate, config.absences, 0.4)
    camera = config.sensor.camera
    out = (camera.width / 2 / camera.fx) * config.distance + 240.0
    return Transform(T.rotation, T.translation + gone[:, None] * [out, 0.0, 0.0])


def _swept(frames: int, most: float) -> Transform:
    """The round that a head turns before a sensor that scans it: from the front, about its neck."""
    share = 2 * np.pi * np.arange(frames) / max(frames, 1)
    turn = most * np.stack([0.25 * np.sin(2 * share), np.sin(share), np.zeros(frames)], 1)
    R = rotation_from_vector(turn)
    return Transform(R, NECK - R @ NECK)


def _during(
    times: Float[np.ndarray, " t"], spans: tuple[tuple[float, float], ...], ease: float
) -> Float[np.ndarray, " t"]:
    """1 within the spans (start, length), easing in before and out after; seconds."""
    total = np.zeros(len(times))
    for start, length in spans:
        up = minimum_jerk((times - start + ease) / ease)
        total = np.maximum(total, up * (1 - minimum_jerk((times - start - length) / ease)))
    return total


def _noisy(picture: UInt8[np.ndarray, "h w 3"], sigma: float, rng: np.random.Generator) -> UInt8[np.ndarray, "h w 3"]:
    if sigma <= 0:
        return picture
    grain = np.stack([cut_noise(picture.shape[:2], 0.0, rng) for _ in range(3)], axis=-1)
    return np.clip(picture + np.float32(sigma) * grain + 0.5, 0, 255).astype(np.uint8)
