"""Which shape of one rig is which of another, though every program spells them in its own way.

Names go over as they stand where both have them. Else they are taken apart into words (`blendShape1.eyeBlink_L` ->
blend, shape, 1, eye, blink + left), and those agree that have the same words on the same side, whatever the case, the
separators and the place of the side; words before and after (a Maya node, a mesh, a copy's number) are passed over.
A shape without a side stands for both sides, and both sides for one without.
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from .facs import FACS23

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_SIDES = {
    "l": "left", "lf": "left", "lft": "left", "left": "left",
    "r": "right", "rt": "right", "rgt": "right", "right": "right",
}  # fmt: skip
_ALIASES = {
    "blink": "eyeblink", "eyeclosed": "eyeblink", "eyeclose": "eyeblink", "fcleyeclose": "eyeblink",
    "mouthclosed": "mouthclose", "lipfunnel": "mouthfunnel", "lippucker": "mouthpucker",
    "aa": "jawopen", "vaa": "jawopen", "vrcvaa": "jawopen", "fclmtha": "jawopen", "vrcblink": "eyeblink",
    "lookup": "eyelookup", "lookdown": "eyelookdown",
}  # fmt: skip
"""Other systems' words (VRM, VRoid, VRChat, Unified Expressions) for shapes that are the same."""
_NOT_THE_SHAPE = {"corrective", "corr", "combo", "fix", "inverse", "inv", "neg", "negative", "over"}
"""With one of these before or behind it a name means something else than the shape."""
_COMMON = 3
"""Names that must share a prefix or suffix before one is passed over that itself speaks of the face."""
_TOLD = 4
"""Examples in a line."""
USED = 0.01
"""A shape whose weight never leaves this is not missed."""


@dataclass(frozen=True)
class NameMatch:
    """How the shapes of a source drive those of a target."""

    sources: tuple[str, ...]
    targets: tuple[str, ...]
    share: Float[np.ndarray, "sources targets"]
    """A target's weight is the sum of the sources' weights times these."""
    loose: tuple[tuple[str, str], ...]
    """(target, source) that agree but are spelled otherwise."""

    def weights(self, weights: Float[np.ndarray, "frames sources"]) -> Float[np.ndarray, "frames targets"]:
        """The target's weights."""
        return weights @ self.share

    @property
    def moved(self) -> tuple[str, ...]:
        """Sources that drive something."""
        return tuple(name for name, row in zip(self.sources, self.share, strict=True) if row.any())

    @property
    def missing(self) -> tuple[str, ...]:
        """Sources that the target has nothing for."""
        return tuple(name for name, row in zip(self.sources, self.share, strict=True) if not row.any())

    def notes(self) -> list[str]:
        """A line on what was matched loosely and one on what is missing, where there is any."""
        lines = []
        if self.loose:
            some = ", ".join(f"{target} = {source}" for target, source in self.loose[:_TOLD])
            more = ", ..." if len(self.loose) > _TOLD else ""
            lines.append(f"{len(self.loose)} shape names matched loosely: {some}{more}")
        if self.missing:
            have = len(self.sources) - len(self.missing)
            lines.append(f"{have} of {len(self.sources)} shapes matched; missing: {', '.join(self.missing)}")
        return lines


def match_names(sources: Sequence[str], targets: Sequence[str], given: Mapping[str, str] | None = None) -> NameMatch:
    """Match two lists of shape names.

    `given` names pairs by hand, source and target in either order; they go first, and pairs of names that neither list
    has are passed over.
    """
    share = np.zeros((len(sources), len(targets)))
    loose: list[tuple[str, str]] = []
    row = {name: i for i, name in enumerate(sources)}
    column = {name: i for i, name in enumerate(targets)}
    for one, other in _pairs_by_hand(row, column, given or {}):
        share[row[one], column[other]] = 1.0
    _as_they_stand(share, row, column)
    _merged(share, row, column)
    for target, source, part in _agreeing(sources, _undriven(targets, _used(share, 0)), _used(share, 1), row):
        share[row[source], column[target]] = part
        loose.append((target, source))
    idle = _undriven(sources, _used(share, 1))
    for source, target, _ in _agreeing(targets, idle, _used(share, 0), column):
        share[row[source], column[target]] = 1.0
        loose.append((target, source))
    return NameMatch(tuple(sources), tuple(targets), share, tuple(loose))


def _used(share: np.ndarray, axis: int) -> np.ndarray:
    return np.asarray(share.any(axis=axis))


def _undriven(names: Sequence[str], driven: np.ndarray) -> list[str]:
    return [name for name, is_driven in zip(names, driven, strict=True) if not is_driven]


def _pairs_by_hand(
    row: Mapping[str, int], column: Mapping[str, int], given: Mapping[str, str]
) -> Iterable[tuple[str, str]]:
    for one, other in given.items():
        if one in row and other in column:
            yield one, other
        elif other in row and one in column:
            yield other, one


def _as_they_stand(share: np.ndarray, row: Mapping[str, int], column: Mapping[str, int]) -> None:
    for name in row:
        if name in column and not share[row[name]].any() and not share[:, column[name]].any():
            share[row[name], column[name]] = 1.0


def _merged(share: np.ndarray, row: Mapping[str, int], column: Mapping[str, int]) -> None:
    """The merged shapes of `FACS23`, where only one of the two has its shapes merged."""
    for name, parts in FACS23.items():
        ours = [part for part in parts if part in row and not share[row[part]].any()]
        theirs = [part for part in parts if part in column and not share[:, column[part]].any()]
        if name in row and not share[row[name]].any():
            for part in theirs:
                share[row[name], column[part]] = 1.0
        elif name in column and not share[:, column[name]].any():
            for part in ours:
                share[row[part], column[name]] = 1.0 / len(parts)


# --- words -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Name:
    words: tuple[str, ...]
    """Lower case, without the side."""
    side: str
    """"left", "right" or ""."""

    @property
    def flat(self) -> str:
        return "".join(self.words)


def _taken_apart(name: str) -> _Name:
    words = [word.lower() for word in _WORD.findall(name)]
    sided = [i for i, word in enumerate(words) if word in _SIDES]
    if sided:
        side = _SIDES[words.pop(sided[-1])]
        return _Name(tuple(words), side)
    for i in [len(words) - 1, 0] if words else []:
        for side in ("left", "right"):
            if words[i].endswith(side) and i == len(words) - 1:
                return _Name((*words[:i], words[i].removesuffix(side)), side)
            if words[i].startswith(side) and i == 0:
                return _Name((words[i].removeprefix(side), *words[1:]), side)
    return _Name(tuple(words), "")


class _Reference:
    """Names to be recognised in other spellings."""

    def __init__(self, names: Iterable[str]):
        self.by_key: dict[tuple[str, str], str] = {}
        self.by_words: dict[tuple[str, tuple[str, ...]], str] = {}
        self.vocabulary: set[str] = set()
        self.stems: set[str] = set()
        for name in names:
            apart = _taken_apart(name)
            self.by_key.setdefault((apart.side, apart.flat), name)
            self.by_words.setdefault((apart.side, tuple(sorted(apart.words))), name)
            self.vocabulary |= set(apart.words)
            self.stems.add(apart.flat)

    def named(self, side: str, stem: str) -> list[tuple[str, float]]:
        """Names of that stem on that side, each with its share; both sides for one without, and the other way round."""
        stem = stem if stem in self.stems else _ALIASES.get(stem, stem)
        if (side, stem) in self.by_key:
            return [(self.by_key[side, stem], 1.0)]
        if side and ("", stem) in self.by_key:
            return [(self.by_key["", stem], 1.0)]
        both = [self.by_key[s, stem] for s in ("left", "right") if (s, stem) in self.by_key]
        if not side and len(both) == 2:
            return [(name, 0.5) for name in both]
        short = {"l": "left", "r": "right"}.get(stem[-1:], "")
        if not side and short and ({"left", "right"} <= {s for s, flat in self.by_key if flat == stem[:-1]}):
            return [(self.by_key[short, stem[:-1]], 1.0)]
        return []


@dataclass(frozen=True)
class _Meaning:
    rank: int
    """0: the same words; 1: in another order; 2: other words before or behind."""
    means: tuple[tuple[str, float], ...]
    affix: tuple[str, str] = ("", "")
    """Words passed over before and behind."""
    doubtful: bool = False
    """The words left are too few to tell without other names that bear the same words around."""


def _agreeing(
    reference: Sequence[str], foreign: Sequence[str], taken: np.ndarray, place: Mapping[str, int]
) -> Iterable[tuple[str, str, float]]:
    """(foreign, reference, share) of names that agree; of several that mean the same the plainest spelling."""
    book = _Reference(reference)
    meanings = {name: found for name in foreign if (found := _meaning(_taken_apart(name), book))}
    common = Counter(found.affix for found in meanings.values())
    sound = {name: m for name, m in meanings.items() if common[m.affix] >= _COMMON or not m.doubtful}
    best: dict[str, int] = {}
    for found in sound.values():
        for name, _ in found.means:
            best[name] = min(best.get(name, found.rank), found.rank)
    for spelled, found in sound.items():
        for name, part in found.means:
            if found.rank == best[name] and not taken[place[name]]:
                yield spelled, name, part


def _meaning(apart: _Name, book: _Reference) -> _Meaning | None:
    words, n = apart.words, len(apart.words)
    if means := book.named(apart.side, apart.flat):
        return _Meaning(0, tuple(means))
    turned = book.by_words.get((apart.side, tuple(sorted(words))))
    if turned:
        return _Meaning(1, ((turned, 1.0),))
    for length in range(n - 1, 0, -1):
        for start in range(n - length, -1, -1):
            before, inner, behind = words[:start], words[start : start + length], words[start + length :]
            stem = "".join(inner)
            if length == 1 and not (apart.side and (apart.side, stem) in book.by_key):
                continue  # one word says a shape only with its side: "smile" may be any part of one
            means = book.named(apart.side, stem)
            if means and not _is_another(before, behind, book):
                affix = (_letters(before), _letters(behind))
                of_the_face = bool(book.vocabulary & {*before, *behind})
                brief = len(inner) == 1 and bool(affix[1])  # "mouth" + "raise" + left is not mouthLeft
                return _Meaning(2, tuple(means), affix, of_the_face or brief)
    return None


def _letters(words: tuple[str, ...]) -> str:
    return " ".join(word for word in words if not word.isdigit())


def _is_another(before: tuple[str, ...], behind: tuple[str, ...], book: _Reference) -> bool:
    """The words around hold a further shape, or say that this is not the shape itself."""
    if _NOT_THE_SHAPE & {*before, *behind}:
        return True
    return any("".join(part[i:j]) in book.stems for part in (before, behind) for i, j in _spans(len(part)))


def _spans(n: int) -> list[tuple[int, int]]:
    """Runs of two words or more."""
    return [(i, j) for i in range(n) for j in range(i + 2, n + 1)]
