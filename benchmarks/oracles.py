"""What a take allows at best, by oracles that know the truth.

    python benchmarks/oracles.py [--only markers100 markers30 rgbd colour scans] [--takes FOLDER] [--played FOLDER]
    python benchmarks/oracles.py --staged 501 502 [--kind stranger] [--seconds 3]

The true neutral mesh in the true head pose, moved by a smooth spline under the markers as they were recorded, and under
the skin that they sit on: % of the frozen baseline, take / strongest tenth. With `--played`, the `--work` folder of
`strangers.py`, the error of its weights too, as they are and with the best scale a shape.

An RGB-D take (two minutes): what is tracked; the weights that were played, and the best ones for every true place of
the skin, on the person's rig; shapes scaled or relearnt for the weights that were found; the error along the skin taken
away; the take tracked anew with such scales, with the true neutral, with the true head pose. Its colour alone (a
minute): what is tracked, and where the head is off; the same with parts of the head's motion as they truly were; the
head told from the true picture of all the skin; the true lens, and a rig that was made with depth. `--staged`: what is
tracked of staged performers' colour alone.

A take on scans (three minutes): as registered; with scans and their frames' markers in the true head; with every vertex
where it belongs on the scans; with scans that show their frames exactly. The takes lie in `shared/strangers`; without
them nothing is run.
"""

import argparse
from pathlib import Path

import numpy as np
from oracles_colour import colour, staged
from oracles_rgbd import rgbd
from oracles_scans import scans
from shares import shares
from strangers import default_takes

from mien.io.gltf import read_performance
from mien.io.markers import read_markers
from mien.mesh import Attachment, Mesh, closest_point
from mien.register.interpolate import interpolate_from_points
from mien.takes.gaps import fill_gaps
from mien.transforms import Transform

REACH_MM = 40.0
"""A marker's pull fades beyond about so far; 17 to 100 mm change a percent or two."""
STEP = 12
"""Every so many frames are scored."""
TAKES = ("markers100", "markers30", "rgbd", "colour", "scans")
SCALES = np.r_[0.0, np.geomspace(0.1, 10.0, 60)]
"""Scales of a weight that are tried."""


def interpolation(folder: Path) -> None:
    """The bound of smooth interpolation between the markers of one take."""
    truth = dict(np.load(folder / "truth.npz"))
    take = read_markers(folder / "take.c3d")
    T_lab_head = Transform(truth["rotation"].astype(float), truth["translation"].astype(float))
    seen = fill_gaps(T_lab_head.inverse().apply(take.positions), take.rate)
    rest = np.nanmean(seen[truth["still"]], axis=0)
    neutral, faces, skin = truth["neutral"].astype(float), truth["faces"].astype(int), truth["open"]
    outer = np.flatnonzero(skin[faces].all(axis=1))
    under = closest_point(Mesh(neutral, faces[outer]), rest)
    places = Attachment(outer[under.faces], under.barycentric)
    S = interpolate_from_points(Mesh(neutral, faces), places, REACH_MM)[skin]
    frames = np.arange(0, len(seen), STEP)
    moved = np.tensordot(truth["coefficients"][frames], truth["modes"], 1)
    D = places.matrix(Mesh(neutral, faces))
    of_skin = np.stack([D @ shape for shape in moved])
    for what, pulled in (("markers", np.nan_to_num(seen - rest)[frames]), ("their skin", of_skin)):
        print(f"{folder.name}, {what}: {shares(np.einsum('vk,tkd->tvd', S, pulled), moved[:, skin])}")


def weights(folder: Path, played: Path) -> None:
    """The mean error of a solve's weights as they are, and with the best scale a shape."""
    truth, performance = dict(np.load(folder / "truth.npz")), read_performance(played)
    names = [str(name) for name in truth["arkit_names"]]
    found = performance.weights[:, [performance.rig.index(name) for name in names]]
    true = truth["arkit"]
    best = [min(np.abs(s * a - b).mean() for s in SCALES) for a, b in zip(found.T, true.T, strict=True)]
    mean = [np.abs(error).mean() for error in (found - true, 1.5 * found - true, true)]
    cells = f"{mean[0]:.3f}; best scales {np.mean(best):.3f}; all by 1.5 {mean[1]:.3f}; zeros {mean[2]:.3f}"
    print(f"{folder.name}, weights: {cells}")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=TAKES, default=TAKES)
    parser.add_argument("--takes", type=Path, default=default_takes())
    parser.add_argument("--played", type=Path)
    parser.add_argument("--staged", type=int, nargs="+", metavar="SEED")
    parser.add_argument("--kind", choices=["bent", "stranger"], default="bent")
    parser.add_argument("--seconds", type=float, default=3.0)
    options = parser.parse_args()
    for seed in options.staged or ():
        staged(seed, options.kind, options.seconds)
    if options.staged:
        return
    if options.takes is None or not options.takes.is_dir():
        print("oracles: skipped, there is no folder shared/strangers (say --takes)")
        return
    for name in options.only:
        if name in ("rgbd", "colour"):
            {"rgbd": rgbd, "colour": colour}[name](options.takes / "rgbd")
            continue
        if name == "scans":
            scans(options.takes)
            continue
        interpolation(options.takes / name)
        if options.played:
            weights(options.takes / name, options.played / f"{name}.glb")


if __name__ == "__main__":
    main()
