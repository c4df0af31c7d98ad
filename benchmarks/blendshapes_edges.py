"""Awkward captures of one staged person through the steps of `mien rig`, scored by true correspondence; a picture.

    python benchmarks/blendshapes_edges.py [-o edges.png] [--seed 501] [--only flush,glasses]

Scans are the performer's own surface with its colours, as photogrammetry would give it: what is seen is the
awkwardness, not a sensor's noise. Distances are from where the truth has the same skin, mm, mean and 95th percentile,
over what each capture shows; `smile` is the one that the spoilt ones are to be held against. Above in the picture: what
was scanned. Below: the rig's shape with its texture.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mien.blendshapes.assemble import with_masks
from mien.blendshapes.corrections import Correction
from mien.blendshapes.cylinder_map import CylinderLayout, CylinderMap, map_of_scan, mesh_of_map
from mien.blendshapes.expression import BuiltShape, NeutralFace, RigConfig, build_shape, neutral_face
from mien.errors import BadInput
from mien.experiments.blendshapes_figures import face_look, front_of, posed_picture
from mien.experiments.blendshapes_score import TrueSkin, true_skin
from mien.experiments.blendshapes_stage import CaptureStageConfig, capture_actor
from mien.experiments.blendshapes_ways import errors_of
from mien.faces import ARKIT_NAMES
from mien.faces.bundled import BundledFace, load_face
from mien.landmarks.detector import GROUPS
from mien.mesh import Mesh, Scan
from mien.pictures import Renderer, contact_sheet, frontal_camera, write_png
from mien.pictures.color import to_linear, to_srgb
from mien.pictures.show import rig_look
from mien.stage import Performer, Skin
from mien.stage.sensors.occluders import join
from mien.stage.sensors.worn import wear

SMILE = {"mouthSmileLeft": 0.9, "mouthSmileRight": 0.9, "cheekSquintLeft": 0.5, "cheekSquintRight": 0.5}
PIXELS = 260
CHEEKS_MM, CHEEK_MM = np.array([[38.0, -25.0], [-38.0, -25.0]]), 22.0
"""Middles of a flush, face space, and its radius."""
FLUSH = np.array([1.35, 0.8, 0.8])
"""Light of the flush, as a share."""
DARKER, WARMER = 0.45, np.array([1.15, 1.0, 0.8])
"""Another exposure and white balance, as a share of the light."""


@dataclass(frozen=True)
class Case:
    """One awkward capture."""

    weights: dict[str, float]
    spoil: Callable[[Mesh, Performer | Skin], Mesh] = lambda mesh, _: mesh
    """What is done to the scan before it is laid out."""
    cut_mm: float | None = None
    """Nothing above this height is scanned."""
    by_hand: Correction = field(default_factory=Correction)


def lit(mesh: Mesh, light: np.ndarray) -> Mesh:
    """Colours under another light, a share of the old one."""
    return replace(mesh, colors=np.clip(to_srgb(to_linear(mesh.colors) * light), 0, 1))


def flushed(mesh: Mesh, _: Performer | Skin) -> Mesh:
    """Blood in the cheeks, which no point of the mesh tells."""
    off = np.linalg.norm(mesh.vertices[:, None, :2] - CHEEKS_MM, axis=2).min(1)
    share = np.exp(-((off / CHEEK_MM) ** 2))[:, None] * (mesh.vertices[:, 2:] > 0)
    return lit(mesh, 1 + share * (FLUSH - 1))


def with_glasses(mesh: Mesh, actor: Performer | Skin) -> Mesh:
    """Rims and temples over the skin."""
    worn = wear(actor, "glasses")
    frame = replace(worn.mesh, vertices=worn.vertices(mesh.vertices, mesh.faces))
    return join([mesh, frame])


NO_BROW: dict[int, tuple[float, float] | None] = dict.fromkeys(GROUPS["brow_left"])
CASES = {
    "jaw wide open": Case({"jawOpen": 1.0}),
    "one eye closed": Case({"eyeBlinkLeft": 1.0}),
    "smile": Case(SMILE),
    "two exposures": Case(SMILE, lambda mesh, _: lit(mesh, DARKER * WARMER)),
    "flush": Case(SMILE, flushed),
    "glasses": Case(SMILE, with_glasses),
    "no landmarks of a brow": Case(SMILE, by_hand=Correction(NO_BROW)),
    "cut at the hair line": Case(SMILE, cut_mm=70.0),
    "cut at half the forehead": Case(SMILE, cut_mm=52.0),
    "cut at the brows": Case(SMILE, cut_mm=38.0),
}


def scanned(actor: Performer | Skin, case: Case) -> CylinderMap:
    """The performer's surface laid out, spoilt."""
    weights = np.array([case.weights.get(unit, 0.0) for unit in ARKIT_NAMES])
    mesh = case.spoil(Mesh(actor.vertices(weights[None])[0], actor.neutral.faces, colors=actor.neutral.colors), actor)
    map_ = map_of_scan(Scan(mesh, name=next(iter(case.weights), "neutral")), CylinderLayout())
    if case.cut_mm is None:
        return map_
    gone = ~(map_.positions[..., 1] < case.cut_mm)
    cut = [np.where(gone[..., None], np.nan, image) for image in (map_.positions, map_.colors)]
    return CylinderMap(map_.layout, *cut, np.where(gone, 0, map_.confidence), map_.name)


def scored(shape: BuiltShape, case: Case, truth: TrueSkin, neutral: NeutralFace, face: BundledFace) -> str:
    """The shape's errors, told."""
    found = np.where(shape.seen[:, None], neutral.artist.mesh.vertices + shape.delta, np.nan)
    weights = np.array([case.weights.get(unit, 0.0) for unit in ARKIT_NAMES])
    off = errors_of(found, truth, weights, neutral, face)
    return f"mean {off['mean']:.2f} mm, p95 {off['p95']:.1f} mm, drift {off['drift median']:.1f} texels"


def pictures(map_: CylinderMap, shape: BuiltShape | None, neutral: NeutralFace, face: BundledFace) -> list[np.ndarray]:
    """The scan and the rig's shape, both from the front; black where there is none."""
    mesh = neutral.artist.mesh
    scan = mesh_of_map(map_, 2)
    rest = with_masks(neutral, [], face, RigConfig())
    view = frontal_camera(mesh, PIXELS, frame=front_of(rest.rig))
    drawn = Renderer(scan.mesh, replace(rig_look(scan.mesh), occlusion=12), scan.texture).draw(*view)
    if shape is None:
        return [drawn, np.zeros_like(drawn)]
    textured = with_masks(neutral, [shape], face, RigConfig())
    renderer = Renderer(mesh, face_look(textured.rig), textured.rig.texture)
    return [drawn, posed_picture(textured, {shape.name: 1.0}, renderer, view)]


def main() -> None:
    """Scan, build, score, draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("edges.png"))
    parser.add_argument("--seed", type=int, default=501)
    parser.add_argument("--only", help="cases, with commas between; all where not given")
    given = parser.parse_args()
    chosen = list(CASES) if given.only is None else given.only.split(",")
    face, actor = load_face(), capture_actor(given.seed, CaptureStageConfig())
    neutral = neutral_face(scanned(actor, Case({})), face, RigConfig())
    truth = true_skin(actor, neutral.map, neutral.artist)
    above, below = [], []
    for name in chosen:
        case = CASES[name]
        map_, shape = scanned(actor, case), None
        try:
            shape = build_shape(map_, neutral, face, RigConfig(), case.by_hand)
            print(f"{name:26} {scored(shape, case, truth, neutral, face)}", flush=True)
        except BadInput as error:
            print(f"{name:26} {error}", flush=True)
        top, bottom = pictures(map_, shape, neutral, face)
        above.append(top)
        below.append(bottom)
    half = (len(chosen) + 1) // 2 if len(chosen) > 5 else len(chosen)
    rows = [slice(0, half), slice(half, None)] if len(chosen) > 5 else [slice(None)]
    cells = [cell for part in rows for cell in (*above[part], *below[part])]
    captions = [name for part in rows for name in (*chosen[part], *[""] * len(chosen[part]))]
    write_png(given.output, contact_sheet(cells, captions, half))
    print(given.output)


if __name__ == "__main__":
    main()
