"""Performances, rigs, scans, markers and films gathered into one scene for the page."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..blendshapes.build.masks import TexturedRig
from ..camera import Camera
from ..clip import Markers
from ..errors import BadInput
from ..faces import load_face
from ..mesh import Mesh, Scan
from ..pictures.colormap import LEVELS, table
from ..pictures.show import head_motion, same_topology
from ..rig import Performance, Rig
from ..transforms import Transform, quaternions_from_rotations
from .gpu_face import face_of, textures_in_step
from .marker_overlay import markers_in_world
from .scene_file import SceneWriter
from .worst_regions import RegionMisfit

MOST_SIDE_BY_SIDE = 4
"""Faces in one page: more are too narrow to see."""

SEEN_SHARE = 0.9
"""Of the frames that were tracked: a face that is in a film's picture in these was tracked there."""


@dataclass(frozen=True)
class Shown:
    """One thing to be shown."""

    name: str
    """As the page calls it."""
    thing: Performance | Rig | Scan | Markers
    path: Path | None = None
    """The file that it came from; corrections are kept beside it."""
    units: str | None = None
    """Of the file, as asked for."""
    textured: TexturedRig | None = None
    """Whose textures go with the shapes of a performance or rig."""
    regions: tuple[RegionMisfit, ...] = ()
    """Of a registered scan, worst first."""


@dataclass(frozen=True)
class Film:
    """A video that goes beside the face."""

    name: str
    path: Path
    camera: Camera | None = None
    """That took it, in pixels of the take; None where nothing says so."""


def pack_scene(shown: Sequence[Shown], films: Sequence[Film] = (), live: bool = False) -> bytes:
    """The scene as the page loads it (`scene_file`); a `live` one then hears its frames as they come.

    Raises:
        BadInput: no face, or too many.
    """
    faces = [one for one in shown if not isinstance(one.thing, Markers)]
    takes = [one for one in shown if isinstance(one.thing, Markers)]
    if not faces:
        raise BadInput("view: nothing to show a face with; give a performance, a rig or a scan beside it")
    if len(faces) > MOST_SIDE_BY_SIDE:
        raise BadInput(f"view: {len(faces)} faces are too many for one page; give {MOST_SIDE_BY_SIDE} at most")
    scene = SceneWriter()
    first = next((one.thing for one in faces if isinstance(one.thing, Performance)), None)
    header = {
        "faces": [_face(one, scene) for one in faces],
        "markers": [_markers(one, first, scene) for one in takes],
        "films": [_film(i, film, first) for i, film in enumerate(films)],
        "live": live,
        "palette": scene.array(table("heat")[:LEVELS], "f4"),
    }
    return scene.file(header)


def _film(number: int, film: Film, first: Performance | None) -> dict[str, Any]:
    """Where the page finds a film and, where a performance was tracked in it, its camera and T_mean_camera (+Y up)."""
    told: dict[str, Any] = {"name": film.name, "address": f"media/{number}{film.path.suffix}"}
    if film.camera is not None and first is not None and is_before(film.camera, first):
        T_mean_camera = mean_pose(first).inverse()
        turn = quaternions_from_rotations(T_mean_camera.rotation[None])[0]
        told["camera"] = asdict(film.camera)
        told["place"] = [*T_mean_camera.translation.tolist(), *turn.tolist()]
    return told


def is_before(camera: Camera, performance: Performance) -> bool:
    """Whether a camera at the world's origin, looking along -Z, has the face in its picture in nearly every frame.

    That is where `mien track` leaves faces; those of marker takes stand elsewhere.
    """
    pose = performance.T_world_face
    middles = pose.translation + pose.rotation @ performance.rig.neutral.vertices.mean(axis=0)
    middles = middles[performance.tracked] * [1, -1, -1]
    ahead = middles[middles[:, 2] > 0]
    x, y = camera.project(ahead).T
    within = (x > 0) & (x < camera.width) & (y > 0) & (y < camera.height)
    return int(within.sum()) >= SEEN_SHARE * max(len(middles), 1)


def _face(one: Shown, scene: SceneWriter) -> dict[str, Any]:
    """What stays the same, and what was recorded."""
    rig = rig_of(one.thing)
    told: dict[str, Any] = {"name": one.name, "kind": type(one.thing).__name__.lower()}
    told["regions"] = [asdict(region) for region in one.regions]
    told |= face_of(rig, scene) | {"eyes": eyes_of(rig.neutral)}
    if one.textured is not None:
        told |= textures_in_step(one.textured, rig.names, scene)
    if isinstance(one.thing, Performance):
        told["motion"] = _motion(one.thing, scene)
    return told


def rig_of(thing: Performance | Rig | Scan | Markers) -> Rig:
    """The shapes of a thing; a scan has none."""
    if isinstance(thing, Performance):
        return thing.rig
    if isinstance(thing, Scan):
        return Rig(thing.mesh, np.zeros((0, *thing.mesh.vertices.shape)), (), thing.texture)
    if isinstance(thing, Markers):
        raise ValueError("thing: markers have no shapes")
    return thing


def eyes_of(mesh: Mesh) -> list[list[float]]:
    """Centre (3) and radius of both eyeballs, mm, on the bundled face; none elsewhere."""
    face = load_face()
    if not same_topology(face.rig.neutral, mesh):
        return []
    balls = [face.eyeball(mesh.vertices, side) for side in ("left", "right")]
    return [[*map(float, centre), radius] for centre, radius in balls]


def _motion(performance: Performance, scene: SceneWriter) -> dict[str, Any]:
    """Weights and head, about the head's mean pose."""
    motion = head_motion(performance)
    turns = quaternions_from_rotations(motion.rotation)
    return {
        "frames": len(performance),
        "rate": float(performance.rate),
        "shapes": performance.weights.shape[1],
        "weights": scene.array(performance.weights, "f4"),
        "poses": scene.array(np.concatenate([motion.translation, turns], axis=1), "f4"),
        "untracked": np.flatnonzero(~performance.tracked).tolist(),
    }


def _markers(one: Shown, beside: Performance | None, scene: SceneWriter) -> dict[str, Any]:
    """Markers about the head's mean pose; unseen ones are far away."""
    take = one.thing
    assert isinstance(take, Markers)
    if beside is None:
        raise BadInput(f"{one.name}: markers are shown over a performance that was solved from them; give that too")
    world = markers_in_world(take, beside)
    points = mean_pose(beside).inverse().apply(world.reshape(-1, 3)).reshape(world.shape)
    known = np.where(np.isfinite(points).all(axis=2, keepdims=True), points, UNSEEN_MM)
    return {
        "name": one.name,
        "labels": list(take.labels),
        "rate": float(take.rate),
        "frames": len(points),
        "places": scene.array(known, "f4"),
    }


UNSEEN_MM = 1e7
"""Where a marker goes that was not seen: out of every picture."""


def mean_pose(performance: Performance) -> Transform:
    """T_world_mean: the pose that `head_motion` is about."""
    return performance.T_world_face[0] @ head_motion(performance)[0].inverse()
