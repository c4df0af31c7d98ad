"""The paper's light rig on the stage: two cameras, a projector, lamps all round, a face that moves between patterns."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ..camera import Camera
from ..light.disk.light_scan import LightScan
from ..light.integrate import integrate
from ..light.light_rig import LightRig, RigView
from ..light.patterns import PatternSet, paper_set, profile
from ..light.pipeline import LightConfig, LightSources, light_scan, light_sources, moment
from ..light.training.dots import masked_blur
from ..light.triangulate import pixel_rays, surface_normals
from ..mesh import Mesh
from ..stage.people.skin import Skin
from ..stage.sensors.active_light import ActiveLightConfig, Dots, Placed, Slot, look, picture
from ..stage.sensors.marker_layout import marker_layout
from ..transforms import Transform, rotation_looking_along


@dataclass(frozen=True)
class LightStageConfig:
    """Where everything stands."""

    size: tuple[int, int] = (768, 1024)
    """Of the cameras, width and height: a face is tall."""
    projector: tuple[int, int] = (1024, 768)
    distance_mm: float = 700.0
    baseline_mm: float = 240.0
    dots: int = 0
    """Of make-up on the skin; the paper's actor wears 178."""
    centre: tuple[float, float, float] | None = None
    """Of the face, where everything looks (face space, mm); None: of the first expression's front."""
    faults: ActiveLightConfig = ActiveLightConfig()


@dataclass(frozen=True)
class StagedCapture:
    """One capture's pictures and what was really there."""

    images: dict[str, Float[np.ndarray, "slots h w"]]
    """By camera."""
    patterns: PatternSet
    rig: LightRig
    T_rig_face: Transform
    skin: Mesh
    ends: tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]
    """The true vertices in the first slot and in the last, face space, mm."""

    def truth(self, slot: float) -> Mesh:
        """The face at a moment of the capture, rig space, mm."""
        share = slot / max(len(self.patterns) - 1, 1)
        vertices = (1 - share) * self.ends[0] + share * self.ends[1]
        return self.skin.with_vertices(self.T_rig_face.apply(vertices))


def staged_rig(
    centre: Float[np.ndarray, " 3"], config: LightStageConfig = LightStageConfig()
) -> tuple[LightRig, Transform]:
    """The rig before a face whose middle is `centre` (face space), and T_rig_face."""
    width, height = config.size
    focal = 0.9 * height / 225.0 * config.distance_mm
    camera = Camera(focal, focal, (width - 1) / 2, (height - 1) / 2, width, height)
    wide, tall = config.projector
    beam = tall / 290.0 * config.distance_mm
    half = config.baseline_mm / 2
    eyes = {"left": (-half, 0.0), "right": (half, 0.0), "projector": (0.0, 60.0)}
    poses = {name: looking_at(centre + np.array([x, y, config.distance_mm]), centre) for name, (x, y) in eyes.items()}
    T_rig_face = poses["left"]
    views = {
        name: RigView(name, camera, pose @ T_rig_face.inverse()) for name, pose in poses.items() if name != "projector"
    }
    beamer = Camera(beam, beam, (wide - 1) / 2, (tall - 1) / 2, wide, tall)
    projector = RigView("projector", beamer, poses["projector"] @ T_rig_face.inverse())
    lamps = tuple(tuple(row) for row in T_rig_face.rotation.tolist())
    return LightRig((views["left"], views["right"]), projector, lamps, config.faults.gamma), T_rig_face


def front_centre(vertices: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " 3"]:
    """Middle of the face's front, face space, mm."""
    front = vertices[vertices[:, 2] > np.quantile(vertices[:, 2], 0.4)]
    return (front.min(0) + front.max(0)) / 2


def looking_at(eye: Float[np.ndarray, " 3"], target: Float[np.ndarray, " 3"]) -> Transform:
    """T_camera_face of a camera at `eye` that looks at `target`, upright (face space: +Y up)."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    rotation = rotation_looking_along(forward)
    return Transform(rotation, -rotation @ eye)


def staged_capture(
    skin: Skin,
    start: Float[np.ndarray, " shapes"],
    end: Float[np.ndarray, " shapes"],
    config: LightStageConfig = LightStageConfig(),
    patterns: PatternSet | None = None,
    move_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    seed: int = 0,
) -> StagedCapture:
    """Every slot of one capture while the face goes from `start` to `end` and the head by `move_mm`."""
    patterns = patterns or paper_set(*config.projector)
    first, last = skin.vertices(np.stack([start, end]))
    last = last + np.array(move_mm)
    rig, T_rig_face = staged_rig(front_centre(first) if config.centre is None else np.array(config.centre), config)
    rng = np.random.default_rng([seed, 41])
    still = bool((first == last).all())
    images = {view.name: np.empty((len(patterns), *config.size[::-1])) for view in rig.cameras}
    views = {view.name: Placed(view.camera, view.T_view_rig @ T_rig_face) for view in rig.cameras}
    assert rig.projector is not None
    beamer = Placed(rig.projector.camera, rig.projector.T_view_rig @ T_rig_face)
    dots = worn_dots(skin, config.dots) if config.dots else None
    mesh, seen = skin.neutral, {}
    for number in range(len(patterns)):
        share = number / max(len(patterns) - 1, 1)
        if not number or not still:
            mesh = skin.neutral.with_vertices((1 - share) * first + share * last)
            seen = {name: look(mesh, view, dots) for name, view in views.items()}
        for name in views:
            images[name][number] = picture(seen[name], mesh, beamer, slot_of(patterns, number), config.faults, rng)
    return StagedCapture(images, patterns, rig, T_rig_face, skin.neutral, (first, last))


def worn_dots(skin: Skin, count: int) -> Dots:
    """Painted where markers would be glued, the same ones for every capture."""
    layout = marker_layout(skin, count)
    return Dots(skin.neutral.vertices, layout.attachment.points(skin.neutral))


def slot_of(patterns: PatternSet, number: int) -> Slot:
    """A pattern as the stage's lights know it."""
    pattern = patterns.patterns[number]
    if pattern.kind in ("constant", "tracking"):
        return Slot(gradient=(0.0, 0.0, 0.0))
    if pattern.kind == "gradient":
        axis = "xyz".index(pattern.axis)
        return Slot(gradient=(float(axis == 0), float(axis == 1), float(axis == 2)))
    if pattern.axis == "y":
        return Slot(rows=profile(pattern, patterns.height))
    return Slot(columns=profile(pattern, patterns.width))


@dataclass(frozen=True)
class LightScore:
    """How near to the truth one capture came, over the pixels that were measured."""

    geometry_mm: float
    """Mean distance in depth of the triangulated points."""
    fused_mm: float
    light_deg: float
    """Median angle of the photometric normals."""
    geometry_deg: float
    fused_deg: float
    share: float
    """Of the pixels that show the face, how many were measured."""
    bands: dict[str, tuple[float, ...]]
    """Mean absolute error in depth, mm, from fine to broad (`BANDS_MM`), of `points`, `light` (its normals alone,
    integrated) and `fused`."""


BANDS_MM = (0.5, 2.0, 8.0)
"""Standard deviations of the Gaussians that part errors into bands: finer than the first, between them, broader."""


def score_capture(capture: StagedCapture, config: LightConfig = LightConfig()) -> LightScore:
    """Decode a capture; score the fused scan and both of its sources."""
    sources = light_sources(capture.images, capture.patterns, capture.rig, config)
    return score_scan(light_scan(sources, config.fuse), sources, capture, config)


def score_scan(scan: LightScan, sources: LightSources, capture: StagedCapture, config: LightConfig) -> LightScore:
    """A scan of `sources`, in their cut-out, against the truth."""
    view, base = sources.view, sources.depth
    at = moment(capture.patterns, config.motion) if capture.patterns.of("gradient") else 0.0
    seen = look(capture.truth(at), Placed(view.camera, view.T_view_rig))
    depth, normals = np.full(seen.mask.shape, np.nan), np.full((*seen.mask.shape, 3), np.nan)
    depth[seen.mask], normals[seen.mask] = seen.points[:, 2], seen.normals
    known = np.isfinite(scan.points[..., 2]) & np.isfinite(base.z) & seen.mask
    light = np.full_like(normals, np.nan) if sources.light is None else sources.light.normals
    surfaces = {"points": base.z, "fused": scan.points[..., 2]}
    if sources.light is not None:
        middle = float(depth[known].mean())
        surfaces["light"] = integrate(light, view.camera, pixel_rays(view.camera), known, middle)
    pixel_mm = float(np.median(depth[known])) / view.camera.fx
    return LightScore(
        bands={name: band_errors(z - depth, known, pixel_mm) for name, z in surfaces.items()},
        geometry_mm=float(np.abs(base.z - depth)[known].mean()),
        fused_mm=float(np.abs(scan.points[..., 2] - depth)[known].mean()),
        light_deg=median_angle(light, normals, known),
        geometry_deg=median_angle(surface_normals(base.z, view.camera), normals, known),
        fused_deg=median_angle(scan.normals, normals, known),
        share=float(known.sum() / seen.mask.sum()),
    )


def band_errors(off: Float[np.ndarray, "h w"], known: Bool[np.ndarray, "h w"], pixel_mm: float) -> tuple[float, ...]:
    """Mean absolute value of an error map in each band, mm, fine to broad."""
    known = known & np.isfinite(off)
    finer = np.where(known, off, 0.0)
    out = []
    for sigma in BANDS_MM:
        broader = masked_blur(np.where(known, off, 0.0), known, sigma / pixel_mm)
        out.append(float(np.abs(finer - broader)[known].mean()))
        finer = broader
    return (*out, float(np.abs(finer[known]).mean()))


def median_angle(one: np.ndarray, other: np.ndarray, mask: np.ndarray) -> float:
    """Between unit vectors, degrees; NaN where none is known."""
    cosine = (one * other).sum(-1)[mask]
    cosine = cosine[np.isfinite(cosine)]
    return float(np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1))))) if len(cosine) else float("nan")
