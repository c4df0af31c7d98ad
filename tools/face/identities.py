"""Random people out of MakeHuman's targets, and the identity space that they span."""

import zipfile
from dataclasses import dataclass
from itertools import product

import numpy as np

from .layout import MILLIMETRES, Layout
from .makehuman import Base, read_folder

FOLDERS = ("head", "forehead", "eyebrows", "eyes", "nose", "mouth", "cheek", "chin", "ears", "asym")
OPPOSITES = (("incr", "decr"), ("up", "down"), ("out", "in"), ("forward", "backward"), ("convex", "concave"),
             ("uncompress", "compress"))
UNUSED = ("head-trans", "head-age", "asymm-", "ear-shape-pointed", "ear-shape-triangle")
"""Parts of names: rigid motions of the whole head, ages outside the macro targets' own, the body, fantasy."""
ETHNICITIES, SEXES, AGES = ("african", "asian", "caucasian"), ("female", "male"), ("young", "old")
OLD_SHARE = 0.25
"""Of the average adult: a quarter of the way from MakeHuman's 25-year-old to its 90-year-old."""
STRENGTH = 0.3
"""Standard deviation of a local slider; MakeHuman's own end at 1."""
REACH = {"asym": 0.7, "head": 4.0, "forehead": 4.0, "ear": 3.0, "nose": 1.8}
"""Standard deviation of a slider is less where it would move some vertex by more than this many mm; else 2.2."""
SIZE = 0.03
"""Standard deviation of overall head size beyond what the targets bring, as a share."""


@dataclass(frozen=True)
class Family:
    """Targets that exclude one another: the two ends of one slider, for both sides of the face where there are two."""

    name: str
    """Without side and with both directions: `eye-bag:incr/decr`."""
    ends: dict[str, tuple[np.ndarray, ...]]
    """Side ("l", "r" or "") -> the fields at the slider's two ends (n, 3) mm, or at its one end."""

    def fields(self) -> dict[str, np.ndarray]:
        """Every end by name, as `l-eye-bag:incr`."""
        stem, _, directions = self.name.partition(":")
        words = [":" + word for word in directions.split("/")] if directions else [""]
        return {f"{side}{'-' * bool(side)}{stem}{word}": field
                for side, fields in self.ends.items() for word, field in zip(words, fields, strict=True)}

    def deviation(self) -> float:
        """Standard deviation of this slider among people."""
        largest = max(np.linalg.norm(field, axis=1).max() for fields in self.ends.values() for field in fields)
        return min(STRENGTH, REACH.get(self.name.split("-")[0], 2.2) / largest)

    def field(self, rng: np.random.Generator) -> np.ndarray:
        """A random setting's displacement (n, 3); the two sides nearly alike."""
        deviation = self.deviation()
        common, total = rng.normal(0, deviation), 0
        for fields in self.ends.values():
            w = float(np.clip(common + rng.normal(0, deviation / 5), -0.9, 0.9))
            total = total + (abs(w) * fields[int(w < 0)] if len(fields) == 2 else w * fields[0])
        return total


@dataclass(frozen=True)
class Macro:
    """MakeHuman's macro targets on the face, adults alone: (n, 3) mm each."""

    people: dict[tuple[str, str, str], np.ndarray]
    """(ethnicity, sex, age)."""
    build: dict[tuple[str, str, str, str], np.ndarray]
    """(sex, age, muscle, weight), the last two of min, average, max."""

    def field(self, ethnicity: dict, male: float, old: float, muscle: float, weight: float) -> np.ndarray:
        """The product rule of MakeHuman's modifiers; muscle and weight in -1..1 about the average."""
        sex, age = {"male": male, "female": 1 - male}, {"old": old, "young": 1 - old}
        total = 0
        for s, a in product(SEXES, AGES):
            for e in ETHNICITIES:
                total = total + ethnicity[e] * sex[s] * age[a] * self.people[e, s, a]
            for m, w in product(_levels(muscle).items(), _levels(weight).items()):
                if m[1] * w[1]:
                    total = total + sex[s] * age[a] * m[1] * w[1] * self.build[s, a, m[0], w[0]]
        return total

    def average(self) -> np.ndarray:
        """The average adult: all alike, in the middle."""
        return self.field(dict.fromkeys(ETHNICITIES, 1 / 3), 0.5, OLD_SHARE, 0.0, 0.0)


def _levels(x: float) -> dict[str, float]:
    """-1..1 -> shares of min, average and max."""
    return {"min": max(-x, 0.0), "average": 1 - abs(x), "max": max(x, 0.0)}


def read_macro(wheel: zipfile.ZipFile, base: Base, layout: Layout) -> Macro:
    """The 12 adult people and the 36 adult builds."""
    found = read_folder(wheel, "macrodetails", len(base.vertices), lambda s: "young" in s or "old" in s)
    mm = {name: layout.gather(base, field) * MILLIMETRES for name, field in found.items()}
    people = {k: mm["-".join(k)] for k in product(ETHNICITIES, SEXES, AGES)}
    levels = ("min", "average", "max")
    build = {(s, a, m, w): mm[f"universal-{s}-{a}-{m}muscle-{w}weight"]
             for s, a, m, w in product(SEXES, AGES, levels, levels)}
    return Macro(people, build)


def read_families(wheel: zipfile.ZipFile, base: Base, layout: Layout) -> list[Family]:
    """All local targets, sorted into families, in a fixed order."""
    groups: dict[str, dict[str, dict[str, np.ndarray]]] = {}
    for folder in FOLDERS:
        for stem, field in read_folder(wheel, folder, len(base.vertices), _wanted).items():
            side, name, end = _split(stem)
            groups.setdefault(name, {}).setdefault(side, {})[end] = layout.gather(base, field) * MILLIMETRES
    return [Family(name, {side: tuple(ends[e] for e in sorted(ends)) for side, ends in sorted(sides.items())})
            for name, sides in sorted(groups.items())]


def _wanted(stem: str) -> bool:
    return not any(part in stem for part in UNUSED)


def _split(stem: str) -> tuple[str, str, str]:
    """`l-eye-bag-incr` -> side, family, end (0: the first of OPPOSITES or the left one of asym; 1: the other)."""
    side = stem[0] if stem[:2] in ("l-", "r-") else ""
    name = stem[2:] if side else stem
    if name.startswith("asym-"):
        return "", name[:-2] + ":l/r", str("lr".index(name[-1]))
    for pair in OPPOSITES:
        for i, end in enumerate(pair):
            if name.endswith("-" + end):
                return side, f"{name.removesuffix('-' + end)}:{'/'.join(pair)}", str(i)
    return side, name, "0"


def split_held_out(families: list[Family], share: float = 1 / 3, seed: int = 20110) -> tuple[list, list]:
    """(kept, held out): a fixed random `share` of the families of local shape, by name.

    Families of plain size (`-scale-`) all stay with the kept: any model of faces has those.
    """
    local = [f.name for f in families if "-scale" not in f.name]
    count = round(share * len(families))
    held = set(np.random.default_rng(seed).permutation(sorted(local))[:count])
    return [f for f in families if f.name not in held], [f for f in families if f.name in held]


def random_person(macro: Macro, families: list[Family], rng: np.random.Generator) -> np.ndarray:
    """One adult's displacement from the base mesh (n, 3) mm, rigid motion still in it."""
    shares = rng.dirichlet([0.8] * 3)
    muscle, weight = np.clip(rng.normal(0, 0.45, 2), -1, 1)
    field = macro.field(dict(zip(ETHNICITIES, shares, strict=True)), rng.beta(0.6, 0.6), rng.beta(0.7, 1.7),
                        muscle, weight)
    return field + sum(family.field(rng) for family in families)


def align_all(people: list[np.ndarray], start: np.ndarray, mirror: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """People (n, 3) and after them their mirror images (2 p, n, 3), moved rigidly onto their mean, by `weight` (n,)."""
    both = np.stack(people)
    both, mean = np.concatenate([both, both[:, mirror] * [-1, 1, 1]]), start
    for _ in range(3):
        both = np.stack([align(p, mean, weight) for p in both])
        mean = both.mean(0)
        mean = (mean + mean[mirror] * [-1, 1, 1]) / 2
    return both


def identity_space(people: np.ndarray, weight: np.ndarray, explained: float = 0.995,
                   seed: int = 1) -> tuple[np.ndarray, float]:
    """Aligned people with their mirror images (2 p, n, 3) -> modes (c, n, 3) of one deviation, share explained.

    Mirror images make each mode symmetric or antisymmetric. `weight` (n,) weighs the principal components. Overall
    size varies by SIZE beyond what the people bring, about the face's centre.
    """
    half, mean = len(people) // 2, people.mean(0)
    centre = (mean * weight[:, None]).sum(0) / weight.sum()
    grow = np.tile(1 + SIZE * np.random.default_rng(seed).standard_normal(half), 2)[:, None, None]
    X = (people - mean) * grow + (grow - grow.mean()) * (mean - centre)
    parts = [(X[:half] + X[half:]) / 2, (X[:half] - X[half:]) / 2]
    modes = np.concatenate([_components(part, weight) for part in parts])
    power = ((modes**2) * weight[:, None]).sum((1, 2))
    order = np.argsort(-power)
    shares = np.cumsum(power[order]) / power.sum()
    count = int(np.searchsorted(shares, explained)) + 1
    return modes[order[:count]], float(shares[count - 1])


def _components(X: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """All principal directions of X (p, n, 3) about 0, each as long as its standard deviation."""
    p, n, _ = X.shape
    w = np.sqrt(weight)[:, None]
    _, s, Vt = np.linalg.svd((X * w).reshape(p, -1), full_matrices=False)
    good = s > s[0] * 1e-6
    return (Vt[good] * s[good, None]).reshape(-1, n, 3) / w / np.sqrt(p)


def align(points: np.ndarray, onto: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """`points` moved rigidly onto `onto` (n, 3), least squares under `weight` (n,)."""
    w = weight[:, None] / weight.sum()
    a, b = (points * w).sum(0), (onto * w).sum(0)
    U, _, Vt = np.linalg.svd(((points - a) * w).T @ (onto - b))
    turn = Vt.T @ np.diag([1, 1, np.linalg.det(Vt.T @ U.T)]) @ U.T
    return (points - a) @ turn.T + b
