"""What pairs by hand do to the worst mouth of a staged person's scans, against the truth.

Pairs are true here: points of skin, the worst first and then each far from the others, on the scan whose mouth has the
largest registration error and on its neighbours. Prints, for each count of them, how far the mouth's vertices are from
the skin that they cover at rest, and the registration error, which the truth itself has too.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mien.cli.demo_scans import stage
from mien.faces import load_face
from mien.image_space.constraints import PairConstraint
from mien.io.markers import read_markers
from mien.progress import SILENT
from mien.scans.correspond.fine_scale import FineConfig, register_fine
from mien.scans.pipeline import RegisteredScans, ScansConfig, register_scans
from mien.scans.scan_files import match_scans
from mien.scans.scan_template import FINE_REGIONS
from mien.scans.select.take_selection import read_selection
from mien.stage.score_material import material_under, scan_errors
from mien.transforms import Transform

SEED, SECONDS, MARKERS = 1, 10.0, 100
COUNTS = 6, 20


def registered(folder: Path) -> tuple[dict, RegisteredScans]:
    """Staged scans by name, and what `mien register` makes of them."""
    _, scans = stage(folder, SEED, SECONDS, MARKERS, SILENT)
    frames = read_selection(folder / "selection.json").frames
    files, _ = match_scans(folder / "scans", frames)
    read = [replace(one.read(), name=one.name) for one in files]
    take, config = read_markers(folder / "take.c3d"), ScansConfig(density=1)
    return scans, register_scans(take, read, [one.frame for one in files], load_face(), config)


def rigid_of(found: RegisteredScans) -> list[Transform]:
    """From each scan to face space, as found, without the unit."""
    return [Transform(one.T_face_scan.rotation, one.T_face_scan.translation) for one in found.scans]


def true_places(scans: dict, found: RegisteredScans) -> np.ndarray:
    """(scans, n, 3): where the skin that each vertex covers at rest is, face space, mm."""
    true, rigid = [scans[one.name] for one in found.scans], rigid_of(found)
    places = [T.apply(one.truth.vertices) for T, one in zip(rigid, true, strict=True)]
    actor = true[0].truth.actor
    material, _ = material_under(actor, places[0], found.coarse[0])
    return np.stack([material.points(actor.neutral.with_vertices(x)) for x in places])


def picked(places: np.ndarray, off: np.ndarray, among: np.ndarray, count: int) -> np.ndarray:
    """The vertex that is farthest off, then each farthest from those before."""
    chosen = [int(among[np.argmax(off[among])])]
    away = np.linalg.norm(places[among] - places[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(among[np.argmax(away)]))
        away = np.minimum(away, np.linalg.norm(places[among] - places[chosen[-1]], axis=1))
    return np.array(chosen)


def main() -> None:
    """Print the figures."""
    with TemporaryDirectory() as folder:
        scans, found = registered(Path(folder))
    template, fine, mouth = found.template, found.fine, list(FINE_REGIONS).index("mouth")
    places = true_places(scans, found)
    worst = int(fine.errors[:, mouth].argmax())
    mask = template.regions["mouth"]
    among = np.flatnonzero((mask > 0.7) & (template.fine_weight > 0.3) & template.shown)
    regions = {name: template.regions[name] for name in FINE_REGIONS}
    inputs = {"faces": template.skin.faces, "regions": regions, "scans": [one.mesh for one in found.scans]}
    truth = register_fine(places, **inputs, config=FineConfig(sweeps=0))

    true = [scans[one.name] for one in found.scans]

    def off(vertices: np.ndarray) -> np.ndarray:
        return scan_errors(list(vertices), rigid_of(found), true)[worst]

    print(f"mouth of {found.scans[worst].name}; registration error of the truth {truth.errors[worst, mouth]:.3f}")
    print(f"no pairs: {off(fine.vertices)[mask > 0.5].mean():.3f} mm, error {fine.errors[worst, mouth]:.3f}")
    for count in COUNTS:
        at = picked(places[worst], off(fine.vertices), among, count)
        others = fine.neighbours[worst, mouth].tolist()
        pairs = [PairConstraint((worst, k), places[[worst, k]][:, at]) for k in others]
        held = register_fine(found.coarse, **inputs, weight=template.fine_weight, constraints=pairs)
        mean = off(held.vertices)[mask > 0.5].mean()
        print(f"{count} pairs with each of {len(others)}: {mean:.3f} mm, error {held.errors[worst, mouth]:.3f}")


if __name__ == "__main__":
    main()
