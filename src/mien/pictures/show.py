"""Whole things in pictures: a performance as film or sheet, a rig's shapes, a scan turned, errors as heat maps."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8
from scipy.spatial.transform import Rotation

from .._kernels._spread import cores, pool_of_generator, single_threaded
from ..errors import BadInput
from ..mesh import ClosestPoint, Mesh, Scan
from ..progress import SILENT, Progress
from ..rig import Performance, Rig
from ..transforms import Transform
from .occlusion import ambient_occlusion
from .render import Look, Renderer
from .sheet import contact_sheet, with_scale
from .view import View, frontal_camera

Values = Callable[[int], Float[np.ndarray, " n"]]
"""A frame's number -> one value a vertex, mm."""


@dataclass(frozen=True)
class Shot:
    """How whole things are shown."""

    size: int = 900
    """Pixels a side of a picture or film."""
    yaw_deg: float = 0.0
    """Degrees that the camera goes round towards the subject's left."""
    pitch_deg: float = 0.0
    """Degrees that it goes up."""
    still_head: bool = False
    """Leave the head's motion out, in pictures and in the errors of a heat map."""
    fps: float = 30.0
    """Frames a second that a film has at most."""
    limit: float | None = None
    """Millimetres at the top of a heat map's scale; by default a round number that 99 % keep within."""

    def view(self, mesh: Mesh, frame: Float[np.ndarray, "p 3"] | None = None) -> View:
        """The camera.

        Raises:
            BadInput: a size that is no picture.
        """
        if not 16 <= self.size <= 8192:
            raise BadInput(f"size: expected 16 to 8192 pixels, got {self.size}")
        return frontal_camera(mesh, self.size, np.radians(self.yaw_deg), np.radians(self.pitch_deg), frame=frame)


def rig_look(mesh: Mesh, look: Look = Look()) -> Look:
    """`look` with as much smooth subdivision as makes a rig's outline round; a mesh of 20,000 vertices needs none."""
    n = len(mesh.vertices)
    return replace(look, refine=0 if n >= 20_000 else 1 if n >= 2_000 else 2)


def film_look(mesh: Mesh) -> Look:
    """`rig_look` with half the rays for ambient occlusion, which is found anew in every frame of a film."""
    return replace(rig_look(mesh), occlusion=Look().occlusion // 2)


def head_motion(performance: Performance) -> Transform:
    """T_mean_face: the head's motion about its own mean pose, one a frame; the mean pose faces forwards."""
    pose = performance.T_world_face
    counted = performance.tracked if performance.tracked.any() else np.ones(len(performance), dtype=bool)
    rotation = Rotation.from_matrix(pose.rotation[counted]).mean().as_matrix()
    middle = np.median(pose.translation[counted], axis=0)
    return Transform(rotation, middle).inverse() @ pose


def performance_view(performance: Performance, shot: Shot = Shot()) -> tuple[View, Transform]:
    """A camera that has the head in the picture in every frame, and T_camera_face of every frame."""
    count = len(performance)
    motion = Transform.identity(count) if shot.still_head else head_motion(performance)
    n = len(performance.rig.neutral.vertices)
    some = np.linspace(0, n - 1, min(n, 1500)).astype(int)
    points = [
        motion[t].apply(performance.rig.vertices(performance.weights[t])[some])
        for t in np.unique(np.linspace(0, count - 1, min(count, 40)).astype(int))
    ]
    view = shot.view(performance.rig.neutral, np.concatenate(points))
    camera = view.T_camera_face
    everywhere = Transform(np.tile(camera.rotation, (count, 1, 1)), np.tile(camera.translation, (count, 1)))
    return view, everywhere @ motion


def performance_frames(
    performance: Performance,
    frames: Sequence[int],
    shot: Shot = Shot(),
    look: Look | None = None,
    values: Values | None = None,
    progress: Progress = SILENT,
    textures: Callable[[int], UInt8[np.ndarray, "th tw 3"]] | None = None,
) -> Iterator[UInt8[np.ndarray, "h w 3"]]:
    """Pictures of frames, one by one, drawn side by side on all cores.

    Args:
        look: by default `film_look`.
        values: a heat map's values; each picture then has the scale beside it.
        textures: a frame's number -> its texture; by default the rig's own in every frame.

    Raises:
        BadInput: a frame that there is not.
    """
    count, neutral = len(performance), performance.rig.neutral
    for frame in frames:
        if not 0 <= frame < count:
            raise BadInput(f"frame {frame}: there are {count}, counted from 0")
    look = look or film_look(neutral)
    if values is not None:
        every = max(1, len(frames) // 12)
        look = replace(look, limits=heat_limits([values(t) for t in frames[::every]], shot.limit))
    view, T_camera_face = performance_view(performance, shot)
    still = Renderer(neutral, look, performance.rig.texture)

    def draw(t: int) -> np.ndarray:
        vertices = performance.rig.vertices(performance.weights[t])
        heat = None if values is None else values(t)
        renderer = still if textures is None else still.with_texture(textures(t))
        return _drawn(renderer, View(view.camera, T_camera_face[t]), vertices=vertices, values=heat)

    for done, image in enumerate(side_by_side(draw, frames)):
        progress.update("drawing", done + 1, len(frames))
        yield image


def _drawn(renderer: Renderer, view: View, *, values=None, **more) -> UInt8[np.ndarray, "h w 3"]:
    """A picture; a heat map with its scale."""
    image, look = renderer.draw(*view, values=values, **more), renderer.look
    return image if values is None or look.limits is None else with_scale(image, look.limits, colormap=look.colormap)


def shapes_sheet(
    rig: Rig,
    shot: Shot = Shot(size=300),
    count: int | None = None,
    look: Look | None = None,
    progress: Progress = SILENT,
) -> UInt8[np.ndarray, "h w 3"]:
    """A contact sheet of a rig's neutral face and its first `count` shapes (all where None), each at full weight, with
    their names. `mouthClose` is drawn on `jawOpen`, which it is there to close."""
    names = rig.names[: len(rig.names) if count is None else count]
    renderer, view = Renderer(rig.neutral, look or rig_look(rig.neutral), rig.texture), shot.view(rig.neutral)
    shapes = [rig.neutral.vertices, *(rig.neutral.vertices + rig.deltas[k] for k in range(len(names)))]
    if "mouthClose" in names and "jawOpen" in rig.names:
        shapes[1 + names.index("mouthClose")] += rig.deltas[rig.index("jawOpen")]
    images = []
    for image in side_by_side(lambda vertices: renderer.draw(*view, vertices=vertices), shapes):
        images.append(image)
        progress.update("drawing", len(images), len(shapes))
    return contact_sheet(images, ["neutral", *names])


def scan_picture(
    scan: Scan, shot: Shot = Shot(), look: Look = Look(), values: Float[np.ndarray, " n"] | None = None
) -> UInt8[np.ndarray, "h w 3"]:
    """A still picture of a scan, with its colours, or as a heat map with its scale."""
    if values is not None:
        look = replace(look, limits=heat_limits([values], shot.limit))
    return _drawn(Renderer(scan.mesh, look, scan.texture), shot.view(scan.mesh), values=values)


def turntable(
    scan: Scan,
    shot: Shot = Shot(),
    look: Look = Look(),
    values: Float[np.ndarray, " n"] | None = None,
    *,
    seconds: float = 4.0,
    swing: float = 0.9,
    progress: Progress = SILENT,
) -> Iterator[UInt8[np.ndarray, "h w 3"]]:
    """Pictures of a still mesh while the camera goes to one side, to the other and back, by `swing` radians."""
    if values is not None:
        look = replace(look, limits=heat_limits([values], shot.limit))
    renderer, frames = Renderer(scan.mesh, look, scan.texture), round(seconds * shot.fps)
    sky = ambient_occlusion(scan.mesh, look.occlusion) if look.occlusion else None

    def draw(i: int) -> np.ndarray:
        yaw_deg = shot.yaw_deg + float(np.degrees(swing * np.sin(2 * np.pi * i / frames)))
        return _drawn(renderer, replace(shot, yaw_deg=yaw_deg).view(scan.mesh), values=values, open_sky=sky)

    for done, image in enumerate(side_by_side(draw, range(frames))):
        progress.update("drawing", done + 1, frames)
        yield image


def surface_distance(mesh: Mesh, other: Mesh) -> Float[np.ndarray, " n"]:
    """How far each vertex is from where `other` has it, mm: from the same vertex where the topology is the same,
    else from the nearest point of `other`'s surface."""
    if same_topology(mesh, other):
        return np.linalg.norm(mesh.vertices - other.vertices, axis=1)
    return ClosestPoint(other).query(mesh.vertices).distances


def distance_from(performance: Performance, reference: Mesh) -> Values:
    """`surface_distance` from a still mesh in face space, frame by frame."""
    return lambda t: surface_distance(performance.rig.mesh(performance.weights[t]), reference)


def same_topology(mesh: Mesh, other: Mesh) -> bool:
    """Whether two meshes correspond vertex by vertex."""
    return mesh.vertices.shape == other.vertices.shape and np.array_equal(mesh.faces, other.faces)


def performance_distance(performance: Performance, other: Performance, still: bool = False) -> Values:
    """`surface_distance` between two performances, frame by frame: in the take's world, head pose included, or with
    `still` in face space.

    Raises:
        BadInput: another number of frames.
    """
    if len(performance) != len(other):
        raise BadInput(f"two performances to compare: expected as many frames, got {len(performance)} and {len(other)}")

    def mesh(of: Performance, t: int) -> Mesh:
        shape = of.rig.mesh(of.weights[t])
        return shape if still else shape.with_vertices(of.T_world_face[t].apply(shape.vertices))

    return lambda t: surface_distance(mesh(performance, t), mesh(other, t))


def heat_limits(values: Iterable[Float[np.ndarray, " n"]], limit: float | None = None) -> tuple[float, float]:
    """0 and `limit`, or a round number (1, 2 or 5 times a power of ten) that 99 % of the values keep within.

    Raises:
        BadInput: a limit that is not positive.
    """
    if limit is not None:
        if not limit > 0:
            raise BadInput(f"heat map: the limit must be positive, got {limit:g} mm")
        return 0.0, float(limit)
    pooled = np.concatenate([np.asarray(v).ravel() for v in values])
    pooled = pooled[np.isfinite(pooled)]
    top = float(np.percentile(pooled, 99)) if len(pooled) else 0.0
    if top <= 1e-9:
        return 0.0, 1.0
    power = 10.0 ** np.floor(np.log10(top))
    return 0.0, float(next(s * power for s in (1, 2, 5, 10) if s * power >= top * (1 - 1e-9)))


def film_frames(performance: Performance, fps: float) -> tuple[range, float]:
    """Every so many frames that a film has at most `fps` a second, and the rate that it then has.

    Raises:
        BadInput: a rate that is not positive.
    """
    if not fps > 0:
        raise BadInput(f"film: frames a second must be positive, got {fps:g}")
    step = max(1, int(np.ceil(performance.rate / fps - 1e-6)))
    return range(0, len(performance), step), performance.rate / step


def side_by_side(work: Callable, items: Iterable) -> Iterator:
    """`map(work, items)` in order on all cores, a few ahead, so that a long film never lies in memory whole."""
    ahead = deque()
    with pool_of_generator(cores(), single_threaded) as pool:
        for item in items:
            ahead.append(pool.submit(work, item))
            if len(ahead) > 2 * cores():
                yield ahead.popleft().result()
        while ahead:
            yield ahead.popleft().result()
