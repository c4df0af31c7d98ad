"""One capture of active light, from pictures to a detailed scan: section 3 in its order."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .._kernels._spread import side_by_side
from ..errors import BadInput
from .cut_out import Box, CutOut, lit_cutout
from .decode_phase import decode_gray, decode_phase
from .decode_sinusoids import DecodeConfig, Decoded, decode_sinusoids, structured_moment
from .disk.light_scan import LightScan
from .fuse import NormalFusionConfig, fuse
from .light_rig import LightRig, RigView
from .motion import MotionConfig, compensated, slot_flow
from .normals import GlossConfig, NormalMap, gradient_normals, without_highlights
from .patterns import PatternSet
from .self_check import check_gradients, check_signal
from .triangulate import (
    DepthMap,
    TriangulateConfig,
    cleaned,
    pixel_rays,
    surface_normals,
    triangulate_pair,
    triangulate_projector,
)

WORST_COLUMNS = 0.003
"""Median distance of points from their planes of light, share of the projector's width, at which a calibration is
another rig's: a good one leaves 0.0001, a focal length of another lens (a tenth longer) 0.003, swapped cameras 0.02."""
STRAY_COLUMNS, STRAY = 0.0005, 6.0
"""A point that is farther than either off its plane of light is left out: share of the projector's width, multiples of
the median distance."""
SHAPE_REACH = 3
"""Pixels to either side over which a triangulated surface's normals are taken where light is judged by them."""


@dataclass(frozen=True)
class LightConfig:
    """Everything that can be set."""

    decode: DecodeConfig = DecodeConfig()
    triangulate: TriangulateConfig = TriangulateConfig()
    motion: MotionConfig = MotionConfig()
    gloss: GlossConfig = GlossConfig()
    fuse: NormalFusionConfig = NormalFusionConfig()


@dataclass(frozen=True)
class LightSources:
    """What one capture tells of the surface before its two sources are fused, in the cut-out that shows anything."""

    view: RigView
    """The first camera, cut out likewise."""
    box: Box
    """Of its picture."""
    depth: DepthMap
    light: NormalMap | None
    """None where no gradients were shown."""
    albedo: Float[np.ndarray, "h w"]


def decode_capture(
    images: dict[str, Float[np.ndarray, "slots h w"]],
    patterns: PatternSet,
    rig: LightRig,
    config: LightConfig = LightConfig(),
) -> LightScan:
    """A detailed scan from one capture, its pictures (linear 0..1) by camera.

    Two cameras: camera to camera. One: camera to the calibrated projector. With gradient conditions: normals, motion
    taken out, fused. Without: the geometry alone.

    Raises:
        BadInput: pictures and patterns or calibration that do not belong together; the line says which and what to do.
    """
    sources = light_sources(images, patterns, rig, config)
    size = images[sources.view.name].shape[1:]
    scan = light_scan(sources, config.fuse)
    return scan.in_whole_picture(sources.box, size)


def light_sources(
    images: dict[str, Float[np.ndarray, "slots h w"]],
    patterns: PatternSet,
    rig: LightRig,
    config: LightConfig = LightConfig(),
) -> LightSources:
    """Triangulated depth, and normals from gradients where there are any.

    Raises:
        BadInput: as `decode_capture`.
    """
    views = [view for view in rig.cameras if view.name in images]
    check(images, views, patterns)
    for view in views:
        pictures = images[view.name]
        check_signal(pictures, patterns, view.name, rig.gamma, config.decode)
    shown = [lit_cutout(images[view.name], view, patterns, config.decode) for view in views]
    flows = side_by_side(lambda cut: flow_between(cut.images, patterns, config), shown)
    depth = base_geometry(shown, flows, patterns, rig, config)
    first = shown[0]
    if not patterns.of("gradient"):
        return LightSources(first.view, first.box, depth, None, first.images[patterns.one("full")])
    steady = at_one_moment(first.images, flows[0], patterns, config.motion)
    R_view_lamps = rig.R_view_lamps(first.view)
    leaning = surface_normals(depth.z, first.view.camera)
    check_gradients(steady, patterns, R_view_lamps, leaning)
    light = gradient_normals(steady, patterns, R_view_lamps)
    check_light(depth, light, first.view)
    shape = shape_normals(depth, first.view)
    rays = pixel_rays(first.view.camera)
    light = without_highlights(light, shape, rays, config.gloss)
    return LightSources(first.view, first.box, depth, light, light.albedo)


def shape_normals(depth: DepthMap, view: RigView) -> Float[np.ndarray, "h w 3"]:
    """Normals of the triangulated surface over a window: steady enough to judge light by."""
    return surface_normals(depth.z, view.camera, SHAPE_REACH)


def light_scan(sources: LightSources, config: NormalFusionConfig) -> LightScan:
    """Both sources as one surface; the depth alone where there is no other."""
    depth, light = sources.depth, sources.light
    if light is None:
        return as_scan(depth, None, sources.albedo, sources.view)
    fused = fuse(depth, light, sources.view.camera, config)
    return as_scan(DepthMap(fused.z, depth.sigma_mm), light, sources.albedo, sources.view)


def check(images: dict[str, np.ndarray], views: list[RigView], patterns: PatternSet) -> None:
    """Pictures that fit the list of patterns and the calibration.

    Raises:
        BadInput: they do not.
    """
    if not views:
        raise BadInput("no pictures of any camera that the calibration names")
    for view in views:
        count, height, width = images[view.name].shape
        camera = view.camera
        if count != len(patterns):
            raise BadInput(f"{view.name}: {count} pictures in a capture of {len(patterns)} slots")
        if (height, width) != (camera.height, camera.width):
            raise BadInput(
                f"{view.name}: pictures of {width} x {height}, calibrated at {camera.width} x {camera.height}: "
                "the calibration of another camera or mode"
            )


def base_geometry(
    shown: list[CutOut], flows: list[np.ndarray | None], patterns: PatternSet, rig: LightRig, config: LightConfig
) -> DepthMap:
    """Triangulated depth of the first camera's pixels."""
    views = [cut.view for cut in shown]
    told = list(zip(shown, flows, strict=True))
    decoded = side_by_side(lambda pair: columns(pair[0].images, patterns, config.decode, pair[1]), told)
    if len(views) > 1:
        depth = triangulate_pair(views[0], views[1], decoded[0], decoded[1], config.triangulate)
        if rig.projector is not None:
            depth = within_light(depth, views[0], rig.projector, decoded[0])
        return cleaned(depth, views[0].camera, config.triangulate)
    if rig.projector is None:
        raise BadInput(f"{views[0].name}: one camera needs a calibrated projector, and the calibration has none")
    first = shown[0]
    rows = decode_gray(first.images, patterns, "y") if patterns.of("gray", axis="y") else None
    return triangulate_projector(first.view, rig.projector, decoded[0], config.triangulate, rows)


def check_light(depth: DepthMap, light: NormalMap, view: RigView) -> None:
    """Triangulated surface and photometric normals must lean to the same sides.

    Raises:
        BadInput: they lean to opposite ones, as the hollow face does that two swapped cameras see.
    """
    geometry = surface_normals(depth.z, view.camera)
    both = np.isfinite(geometry).all(-1) & light.known
    leaning = geometry[both][:, 0]
    told = light.normals[both][:, 0]
    if not len(told):
        return
    alike = np.corrcoef(leaning, told)[0, 1]
    if alike < 0:
        raise BadInput(
            "the surface is hollow where its light says it bulges: the two cameras' pictures are swapped, "
            "or the lamps' axes in the calibration (R_rig_lamps) are mirrored"
        )


def within_light(depth: DepthMap, view: RigView, projector: RigView, seen: Decoded) -> DepthMap:
    """Without the points that lie off the planes of light which a calibrated projector threw on them: wrong folds
    of the patterns, and matches across a shadow.

    Raises:
        BadInput: most points lie far off.
    """
    known = np.isfinite(depth.z)
    known &= seen.known
    if not known.any():
        raise BadInput("no point is left after triangulation: are the pictures in focus, and of this calibration?")
    points = depth.points(view.camera)[known]
    T_projector_view = projector.T_view_rig @ view.T_view_rig.inverse()
    ideal = projector.camera.project(T_projector_view.apply(points))
    lit = projector.distorted(ideal)
    off = lit[:, 0] - seen.pixel[known]
    off = np.abs(off)
    usual = float(np.median(off))
    width = projector.camera.width
    if usual > WORST_COLUMNS * width:
        raise BadInput(
            f"points of the two cameras lie {usual:.1f} projector pixels off the patterns on them: "
            "the cameras' pictures are swapped, or the calibration is of another rig"
        )
    most = max(STRAY_COLUMNS * width, STRAY * usual)
    sound = known.copy()
    sound[known] = off < most
    z = np.where(sound, depth.z, np.nan)
    sigma_mm = np.where(sound, depth.sigma_mm, np.nan)
    return DepthMap(z, sigma_mm)


def columns(images: np.ndarray, patterns: PatternSet, config: DecodeConfig, flow: np.ndarray | None = None) -> Decoded:
    """Projector columns by whatever the capture shows: the paper's sinusoids, a phase shift, or Gray codes alone."""
    waves = patterns.of("sinusoid", axis="x")
    periods = {patterns.patterns[slot].periods for slot in waves}
    if len(periods) > 1:
        return decode_sinusoids(images, patterns, config, flow)
    if periods:
        return decode_phase(images, patterns, config)
    return decode_gray(images, patterns)


def flow_between(images: np.ndarray, patterns: PatternSet, config: LightConfig) -> np.ndarray | None:
    """How the picture moves from slot to slot; None where nothing moves, or nobody asks."""
    if not patterns.of("tracking") or not (config.motion.compensate or config.decode.motion):
        return None
    flow = slot_flow(images, patterns, config.motion)
    return flow if flow.any() else None


def at_one_moment(
    images: np.ndarray, flow: np.ndarray | None, patterns: PatternSet, config: MotionConfig
) -> np.ndarray:
    """The lamps' conditions without what moved between them."""
    if flow is None or not config.compensate:
        return images
    return compensated(images, patterns, flow, moment(patterns, config))


def moment(patterns: PatternSet, config: MotionConfig) -> float:
    """The slot in which the scan shows the face."""
    sinusoids = patterns.of("sinusoid", axis="x")
    if not patterns.of("tracking") or (config.to_structured and sinusoids):
        return structured_moment(patterns)
    return float(patterns.one("tracking"))


def as_scan(depth: DepthMap, light: NormalMap | None, albedo: np.ndarray, view: RigView) -> LightScan:
    """Points in rig space."""
    inverse = view.T_view_rig.inverse()
    points = depth.points(view.camera)
    known = np.isfinite(depth.z)
    normals = surface_normals(depth.z, view.camera)
    confidence = np.ones(known.shape) if light is None else light.confidence
    return LightScan(
        points=inverse.apply(points),
        normals=inverse.rotate(normals),
        albedo=albedo,
        confidence=np.where(known, confidence, 0.0),
        sigma_mm=depth.sigma_mm,
    )
